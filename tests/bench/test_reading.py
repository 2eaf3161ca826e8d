from pathlib import Path

from gpu.scene.load import load_scene
from tests.bench.reading import seconds, write_meshes


def test_both_files_hold_the_same_mesh_and_are_timed(tmp_path: Path) -> None:
    files = write_meshes(tmp_path, 800)
    scenes = [load_scene(str(file)) for file in files]
    assert [len(scene.triangles) for scene in scenes] == [800, 800]
    assert scenes[0].bounds == scenes[1].bounds
    assert all(0.0 < seconds(file) < 10.0 for file in files)
