import io
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from fbx_file import FbxFile

from gpu.child_process import module_command

pytest.importorskip("ufbx")


def test_what_a_process_answers(tmp_path: Path) -> None:
    fbx = FbxFile(tmp_path)
    node = fbx.node("Floor", "Mesh", Lcl_Translation=(1.0, 2.0, 3.0))
    fbx.mesh(node)
    fbx.material(node, "Red", DiffuseColor=(0.5, 0.0, 0.0))
    command = module_command("gpu.scene.formats.fbx.extract")
    answer = subprocess.run(command, input=fbx.write().read_bytes(), capture_output=True, check=True)
    arrays = np.load(io.BytesIO(answer.stdout))
    told = json.loads(arrays["json"].tobytes())
    assert arrays["mesh0.counts"].tolist() == [4]
    assert arrays["mesh0.uv"].tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert told["nodes"][1]["name"] == "Floor"
    assert told["nodes"][1]["geometry_to_world"][3] == [1.0, 2.0, 3.0]
    assert told["materials"][0]["base_color"]["value"] == [0.5, 0.0, 0.0, 1.0]
    assert told["metres"] == pytest.approx(0.01)
