from pathlib import Path

import pytest
from gltf_motion import moving

from gpu.scene.edits import ObjectEdit, SceneEdits, shaped
from gpu.scene.pauses import go_on


@pytest.mark.parametrize("what", ["time", "objects"])
def test_others_have_turns_between_what_moves(tmp_path: Path, what: str) -> None:
    scene, paused = moving(tmp_path).load(), list[str]()
    turned = {one: ObjectEdit(rotation=(0.0, 0.0, 1.0)) for one in scene.objects}
    edits = SceneEdits(time=1.0) if what == "time" else SceneEdits(objects=turned)
    shaped(scene, edits, lambda: paused.append(what))
    assert len(paused) >= len(scene.body_triangles if what == "time" else turned) > 1
    shaped(scene, edits, go_on)
