"""What must hold of a reader of scene files, whatever a file has: a sound scene, or an error that names the file."""

import time
from pathlib import Path
from unittest.mock import patch

import numpy as np

from gpu.errors import SceneError
from gpu.scene import default_view
from gpu.scene.limits import SceneLimits
from gpu.scene.load import load_scene
from gpu.scene.summary import summarise, summary_text
from server.scenes.scene_info import describe_scene
from tests.fuzz.seed import Seed

# Far above the seeds, far below what takes long.
LIMITS = SceneLimits(
    max_file_bytes=10**6, max_triangles=10**5, max_vertices=3 * 10**5, max_texture_size=512, max_texture_pixels=10**6
)
SAMPLES = 100  # of surfaces, for a first view: it takes most of the time otherwise
MOST_SECONDS = 5.0  # of processor time: a seed takes hundredths


def read(folder: Path, file: Seed) -> bool:
    """Whether `file`, written into `folder`, is read as a scene. AssertionError, or any other, where it does wrong."""
    for name, content in file.files().items():
        (folder / name).write_bytes(content)
    path = str(folder / file.name)
    began = time.process_time()
    try:
        with patch.object(default_view, "_SAMPLES", SAMPLES):
            scene = load_scene(path, LIMITS)
    except SceneError as error:
        message = str(error)
        assert path in message, message
        assert "\n" not in message, message
        assert len(message) < 2000, message[:2000]
        return False
    finally:
        seconds = time.process_time() - began
        assert seconds < MOST_SECONDS, f"{seconds:.1f} s"
    count = len(scene.vertices)
    assert count
    assert len(scene.triangles) == len(scene.triangle_material)
    assert 0 <= scene.triangles.min() <= scene.triangles.max() < count
    assert 0 <= scene.triangle_material.min() <= scene.triangle_material.max() < len(scene.materials)
    for values in (scene.vertices, scene.normals, scene.uvs, scene.colors):
        assert values is None or np.isfinite(values).all()
    shown = ~np.array([material.backdrop for material in scene.materials])[scene.triangle_material]
    assert not shown.any() or np.abs(scene.vertices[scene.triangles[shown]]).max() < 0.51
    assert scene.cameras
    summary_text(summarise(scene))
    assert len(describe_scene(file.name, scene).model_dump_json()) < 10**6
    return True
