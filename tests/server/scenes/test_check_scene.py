"""The child process that reads a scene: what it says, and what it may not do."""

import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from fbx_file import FbxFile
from glb_file import TRIANGLE, TRIANGLE_GLB, glb, triangle
from ifc_file import House
from step_file import Box, step

from server.scenes.checker import CHECK

OUTSIDE = "a secret beside the folder"

# Checks each scene of which stdin has a line, in a copy of the process with the modules loaded, and answers by a
# line: the answer and the paths of all files that were opened for it.
WATCHED = """
import json
import os
import sys
import server.scenes.check_scene as check_scene
from server.scenes.checked import CheckRequest
import gpu.scene.formats.gltf, gpu.scene.formats.obj, gpu.scene.formats.meshes
opening = lambda name, args: name == "open" and not args[2] & os.O_PATH
for line in sys.stdin.read().splitlines():
    if child := os.fork():
        os.waitpid(child, 0)
        continue
    opened = []
    sys.addaudithook(lambda name, args: opened.append(str(args[0])) if opening(name, args) else None)
    answer = check_scene.check(CheckRequest.model_validate_json(line)).model_dump(mode="json")
    print(json.dumps([answer, opened]), flush=True)
    os._exit(0)
"""
WRITING = """
import os
import sys
from server.scenes.check_scene import check
from server.scenes.checked import CheckRequest
print(check(CheckRequest.model_validate_json(sys.stdin.read())).model_dump_json(), flush=True)
os.write(os.open(sys.argv[1], os.O_CREAT | os.O_WRONLY), b"x")
"""


def request(source: Path, folder: Path | None = None, **changes: Any) -> bytes:
    fields = {
        "source": str(source),
        "folder": None if folder is None else str(folder),
        "limits": {},
        "max_unpacked_bytes": 2**20,
        "memory_bytes": 4 * 2**30,
        "seconds": 20.0,
    }
    return json.dumps(fields | changes).encode()


def check(source: Path, folder: Path | None = None, **changes: Any) -> dict[str, Any]:
    """The answer of a child."""
    done = subprocess.run(
        [*CHECK, str(os.getpid())], input=request(source, folder, **changes), capture_output=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def watched(*sources: Path, first: str = "") -> list[tuple[dict[str, Any], set[Path]]]:
    """Of each the answer, and the files that were opened for it outside Python's own folders; first: a statement."""
    command, lines = [sys.executable, "-c", first + WATCHED], b"\n".join(map(request, sources))
    done = subprocess.run(command, input=lines, capture_output=True, timeout=60)
    own = [Path(path).resolve() for path in {*sysconfig.get_paths().values(), sys.base_prefix}]
    own.append(Path(__file__).resolve().parents[3])

    def foreign(opened: list[str]) -> set[Path]:
        paths = [Path(path).resolve() for path in opened if path.startswith("/")]
        return {path for path in paths if not any(path.is_relative_to(it) for it in own)}

    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(answers) == len(sources), done.stderr
    return [(answer, foreign(opened)) for answer, opened in answers]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An upload's folder, beside a file that is not in it."""
    (tmp_path / "secret.bin").write_text(OUTSIDE * 10)
    (tmp_path / "secret.mtl").write_text("newmtl a\nKd 1 0 0\n")
    folder = tmp_path / "upload"
    folder.mkdir()
    return folder


def test_a_sound_scene_is_described(folder: Path) -> None:
    (folder / "a.glb").write_bytes(TRIANGLE_GLB)
    answer = check(folder / "a.glb")
    assert answer["source"] == str(folder / "a.glb")
    assert answer["info"]["triangles"] == 1
    assert answer["size"] == {
        "vertices": 3, "triangles": 1, "uv_sets": 1, "colored": False, "materials": 1, "texels": 0
    }  # fmt: skip
    assert any("soft sky" in note for note in answer["info"]["notes"])


def test_a_broken_scene_is_refused_with_the_place(folder: Path) -> None:
    (folder / "a.glb").write_bytes(glb(triangle(nodes=[{"mesh": 0, "scale": 7}]), TRIANGLE))
    assert check(folder / "a.glb") == {
        "field": "nodes[0].scale", "problem": "must be an array", "unpacked_bytes": None
    }  # fmt: skip


def test_nothing_outside_the_folder_is_opened(folder: Path) -> None:
    (folder / "link.bin").symlink_to(folder.parent / "secret.bin")
    outside = str(folder.parent / "secret.bin")
    uris = [
        *("../secret.bin", "%2e%2e/secret.bin", "..\\secret.bin", outside, f"file://{outside}", "link.bin"),
        *("/etc/passwd", "http://127.0.0.1:9/x", "deep/../../secret.bin"),
    ]
    scenes = [folder / f"{number}.gltf" for number in range(len(uris))]
    for scene, uri in zip(scenes, uris, strict=True):
        scene.write_text(json.dumps(triangle(buffers=[{"byteLength": 36, "uri": uri}])))
    for scene, uri, (answer, paths) in zip(scenes, uris, watched(*scenes), strict=True):
        assert (answer["field"], paths) == ("buffers[0].uri", {scene}), uri


def test_what_is_beside_the_scene_is_opened(folder: Path) -> None:
    (folder / "a.gltf").write_text(json.dumps(triangle(buffers=[{"byteLength": 36, "uri": "b.bin"}])))
    (folder / "b.bin").write_bytes(TRIANGLE)
    [(answer, paths)] = watched(folder / "a.gltf")
    assert answer["info"]["triangles"] == 1
    assert paths == {folder / "a.gltf", folder / "b.bin"}


def test_no_library_outside_the_folder_is_opened(folder: Path) -> None:
    (folder / "link.mtl").symlink_to(folder.parent / "secret.mtl")
    scenes = [folder / "a.obj", folder / "b.obj"]
    for scene, library in zip(scenes, ("../secret.mtl", "link.mtl"), strict=True):
        scene.write_text(f"mtllib {library}\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for scene, (answer, paths) in zip(scenes, watched(*scenes), strict=True):
        assert (answer["field"], paths) == ("mtllib", {scene})


def test_no_texture_outside_the_folder_is_opened(folder: Path) -> None:
    (folder / "link.png").symlink_to(folder.parent / "secret.bin")
    scenes = [folder / "a.obj", folder / "b.obj"]
    for scene, texture in zip(scenes, ("../secret.bin", "link.png"), strict=True):
        scene.with_suffix(".mtl").write_text(f"newmtl a\nmap_Kd {texture}\n")
        scene.write_text(f"mtllib {scene.stem}.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for scene, (answer, paths) in zip(scenes, watched(*scenes), strict=True):
        assert "outside the scene's folder" in answer["problem"]
        assert paths == {scene, scene.with_suffix(".mtl")}


def test_of_absolute_paths_the_last_part_is_sought_beside_the_scene(folder: Path) -> None:
    secrets = [folder.parent / "secret.mtl", folder.parent / "secret.bin"]
    (folder / "a.mtl").write_text(f"newmtl a\nmap_Kd {secrets[1]}\n")
    (folder / "a.obj").write_text(
        f"mtllib {secrets[0]}\nmtllib /home/me/a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    )
    [(answer, paths)] = watched(folder / "a.obj")
    assert {
        f"material library {secrets[0]} is missing: a.mtl was read",
        "mtllib: '/home/me/a.mtl' was read from 'a.mtl' beside the scene",
        f"texture {secrets[1]} is missing",
    } <= set(answer["info"]["notes"])
    assert paths == {folder / "a.obj", folder / "a.mtl"}


def test_memory_is_limited(folder: Path) -> None:
    (folder / "a.glb").write_bytes(glb(triangle(), bytes(300 * 2**20)))
    answer = check(folder / "a.glb", memory_bytes=512 * 2**20)
    assert "check_memory_bytes" in answer["problem"]


def test_nothing_can_be_written(folder: Path) -> None:
    (folder / "a.glb").write_bytes(TRIANGLE_GLB)
    command = [sys.executable, "-c", WRITING, str(folder / "new")]
    done = subprocess.run(command, input=request(folder / "a.glb"), capture_output=True, timeout=60)
    assert json.loads(done.stdout)["info"]["triangles"] == 1
    assert b"Permission denied" in done.stderr or b"File too large" in done.stderr


def test_scenes_are_read_where_the_kernel_has_no_walls(folder: Path) -> None:
    (folder / "a.glb").write_bytes(TRIANGLE_GLB)
    [(answer, _)] = watched(folder / "a.glb", first="import platform; platform.machine = lambda: ''\n")
    assert answer["info"]["triangles"] == 1


def test_libraries_of_usd_and_fbx_keep_to_the_limits(folder: Path) -> None:
    pytest.importorskip("pxr")
    pytest.importorskip("ufbx")
    mesh = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n"
    points = "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
    (folder / "a.usda").write_text(f'#usda 1.0\ndef Mesh "M" {{\n{mesh}{points}}}\n')
    assert check(folder / "a.usda")["size"]["triangles"] == 1
    fbx = FbxFile(folder)
    fbx.mesh(fbx.node("Floor", "Mesh"))
    assert check(fbx.write())["size"]["triangles"] == 2


def test_a_step_file_is_read_though_its_library_writes_one_in_memory(folder: Path) -> None:
    pytest.importorskip("cascadio", reason="the extra step is not installed")
    (folder / "a.step").write_bytes(step(Box()))
    assert check(folder / "a.step", memory_bytes=2**30)["info"]["triangles"] == 12
    (folder / "a.step").write_bytes(step(Box())[:2000])
    assert "not a STEP file that can be read" in check(folder / "a.step")["problem"]


def test_an_ifc_file_is_read_within_the_limits(folder: Path) -> None:
    pytest.importorskip("ifcopenshell", reason="the extra ifc is not installed")
    (folder / "a.ifc").write_bytes(House().bytes())
    assert check(folder / "a.ifc", memory_bytes=2**30)["info"]["triangles"] == 112


def test_an_archive_may_hold_a_step_file(folder: Path) -> None:
    pytest.importorskip("cascadio", reason="the extra step is not installed")
    with ZipFile(folder.parent / "a.zip", "w") as archive:
        archive.writestr("deep/a.stp", step(Box()))
    assert check(folder.parent / "a.zip", folder)["info"]["triangles"] == 12
