import io
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_motion import moving

from gpu.errors import SceneError
from gpu.scene.animation.motion import STILL, Animation, Channel, Interpolation, Property
from gpu.scene.edits import SceneEdits, edited
from gpu.scene.file_frame import FileFrame
from gpu.scene.limits import DEFAULT_LIMITS, MOST_BESIDE, SceneLimits
from gpu.scene.load import load_scene
from gpu.scene.types import Camera, Light, LightKind, LoadReport, Scene, Sky, Texture, Wrap
from server.scenes.packed_scene import LENGTH_BYTES, read_scene, write_scene

PIXELS = np.arange(2 * 3 * 4, dtype=np.uint8).reshape(2, 3, 4)


def rich() -> Scene:
    """A scene with something of everything."""
    box = load_scene("cornell-box")
    colours = np.full((len(box.vertices), 4), 0.5, np.float32)
    return replace(
        box,
        colors=colours,
        uvs=np.zeros((2, len(box.vertices), 2), np.float32),
        materials=(replace(box.materials[0], base_color=tuple(np.float32([0.5, 0.25, 0.5, 1.0]))), *box.materials[1:]),
        textures=(Texture("a", PIXELS, True, Wrap.MIRROR), Texture("b", PIXELS, False), Texture("c", PIXELS + 1, True)),
        lights=(Light("lamp", LightKind.SPOT, (1.0, 2.0, 3.0), cos_inner=0.9, cos_outer=0.5),),
        sky=Sky((1.0, 1.0, 2.0)),
        cameras=(*box.cameras, Camera("plan", np.eye(4), 2.0, orthographic=True, near=0.5)),
        report=LoadReport(("x was ignored",), 3, ("y was mended",), {"wood.png": 7}),
        frame=FileFrame("z", 0.001, (1e9, 0.0, 1.0)),
        choices={"variant": ("day", "night")},
    )


def written(scene: Scene, folder: Path) -> Path:
    with (path := folder / "scene").open("wb") as file:
        write_scene(scene, file)
    return path


def read(path: Path, limits: SceneLimits = DEFAULT_LIMITS, pause: Callable[[], None] = lambda: None) -> Scene:
    with path.open("rb") as file:
        return read_scene(file, "hall", limits, pause)


def same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, Texture | Camera):
        return all(same(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
    return bool(one == other)


def test_a_scene_comes_back_as_it_was(tmp_path: Path) -> None:
    scene, pauses = rich(), list[int]()
    back = read(written(scene, tmp_path), pause=lambda: pauses.append(1))
    assert [
        field.name for field in fields(Scene) if not same(getattr(scene, field.name), getattr(back, field.name))
    ] == []
    assert back.textures[0].pixels is back.textures[1].pixels
    assert len(pauses) > 5
    assert not back.vertices.flags.writeable


def test_a_scene_without_colours_has_none(tmp_path: Path) -> None:
    assert read(written(replace(rich(), colors=None), tmp_path)).colors is None


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"triangles": np.array([[0, 1, 999_999]], np.int32), "triangle_material": np.zeros(1, np.int32)}, "triangles"),
        ({"triangle_material": np.full(rich().triangle_material.shape, -1, np.int32)}, "triangle_material"),
        ({"normals": np.zeros((1, 3), np.float32)}, "normals"),
        ({"colors": np.full((len(rich().vertices), 4), np.nan, np.float32)}, "colors"),
        ({"vertices": rich().vertices.astype(np.int32)}, "vertices"),
        ({"textures": (Texture("a", PIXELS[..., :3].copy(), True),)}, r"textures\[0\]"),
        ({"lights": (Light("", LightKind.POINT, (-1.0, 0.0, 0.0)),)}, "lights"),
        ({"frame": FileFrame("y", float("nan"))}, "placement"),
        ({"report": LoadReport(beside={"/etc/passwd": 1})}, "report"),
        ({"report": LoadReport(beside={"maps/../../wood.png": 1})}, "report"),
        ({"report": LoadReport(beside=dict.fromkeys(map(str, range(MOST_BESIDE + 1)), 1))}, "report"),
    ],
)
def test_what_is_not_sound_is_refused(wrong: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=f"^hall: {sentence}"):
        read(written(replace(rich(), **wrong), tmp_path))


def test_limits_hold(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="max_triangles"):
        read(written(rich(), tmp_path), SceneLimits(max_triangles=1))


@pytest.mark.parametrize(
    "change",
    [
        lambda data: b"",
        lambda data: data[:-1],
        lambda data: data[: LENGTH_BYTES + 100],
        lambda data: b"\xff" * LENGTH_BYTES + data[LENGTH_BYTES:],
        lambda data: data.replace(b'"<f4"', b'"|O8"', 1),
        lambda data: data.replace(b'"shape": [', b'"shape": [-', 1),
        lambda data: data.replace(b'"pixels": 0', b'"pixels": 9', 1),
        lambda data: data.replace(b'"normals"', b'"abnorms"', 1),
        lambda data: data.replace(b'"metallic": 0.0', b'"metallic": []', 1),
    ],
)
def test_what_is_no_scene_is_refused(change: Callable[[bytes], bytes], tmp_path: Path) -> None:
    buffer = io.BytesIO()
    write_scene(rich(), buffer)
    changed = change(buffer.getvalue())
    assert changed != buffer.getvalue()
    (tmp_path / "scene").write_bytes(changed)
    with pytest.raises(SceneError, match="its reader left no scene"):
        read(tmp_path / "scene")


def test_what_moves_comes_along(tmp_path: Path) -> None:
    scene, edits = moving(tmp_path).load(), SceneEdits(time=1.0)
    back = edited(read(written(scene, tmp_path)), edits)
    assert same(back.vertices, edited(scene, edits).vertices)
    assert not same(back.vertices, scene.vertices)


@pytest.mark.parametrize("change", [{"lights": (STILL,) * 9}, {"cameras": (STILL,) * 9}, {"bodies": "twice"}])
def test_more_that_moves_than_there_is_is_refused(change: dict[str, Any], tmp_path: Path) -> None:
    scene = moving(tmp_path).load()
    assert scene.motion is not None
    change = {"bodies": scene.motion.bodies * 2} if "bodies" in change else change
    with pytest.raises(SceneError, match="hall: motion: its reader left"):
        read(written(replace(scene, motion=replace(scene.motion, **change)), tmp_path))


@pytest.mark.parametrize("changes", [Property.ROUGHNESS, Property.OUTER_CONE])
def test_channels_of_materials_and_lights_that_there_are_not_are_refused(changes: Property, tmp_path: Path) -> None:
    scene = moving(tmp_path).load()
    assert scene.motion is not None
    channel = Channel(9, changes, Interpolation.STEP, np.zeros(1), np.zeros((1, 1, 1)))
    motion = replace(scene.motion, animations=(Animation("turns", 0.0, (channel,)),))
    with pytest.raises(SceneError, match="more that moves than there is"):
        read(written(replace(scene, motion=motion), tmp_path))
