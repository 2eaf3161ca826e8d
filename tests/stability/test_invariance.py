"""An area-lit picture depends neither on the unit of length nor on where the scene lies."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from gltf_file import GltfFile
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scenes import box, quad
from stress import render
from trimesh.creation import icosphere

from gpu.device_scene.upload import DeviceScene
from gpu.film.metrics import rel_mse
from gpu.scene.camera import look_at
from gpu.scene.types import Floats
from gpu.settings import Method

SIZE = (16, 12)
# A turn by no round angle, so that no coordinate is a round number.
TURN = [0.2, -0.33, 0.41, (1.0 - 0.2**2 - 0.33**2 - 0.41**2) ** 0.5]
EXTENTS = st.floats(-1e6, 1e6)


def room(folder: Path, device: str, scale: float, offset: Sequence[float]) -> DeviceScene:
    """A room of one unit with a lamp and a block, scaled and moved by its node, as is the camera in it."""
    file = GltfFile(folder)
    lamp = quad((-0.2, 0.48, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.3))
    ball = icosphere(2, 0.15)
    ball.apply_translation((0.2, -0.3, 0.0))
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.1, 0.3), (0.3, 0.0, 0.0))
    file.add("materials", pbrMetallicRoughness={"baseColorFactor": [0.7, 0.6, 0.5, 1.0], "metallicFactor": 0.0})
    file.add("materials", emissiveFactor=[1.0, 0.9, 0.8])
    primitives = [
        file.primitive(part.positions, part.triangles.ravel(), material=material)
        for part, material in [*((wall, 0) for wall in box()), (block, 0), (lamp, 1)]
    ]
    primitives.append(file.primitive(ball.vertices, ball.faces.ravel(), material=0))
    inside = look_at((0.1, 0.05, 0.42), (-0.05, -0.1, -0.5), yfov_degrees=75.0)
    view = {"yfov": 1.3, "aspectRatio": SIZE[0] / SIZE[1], "znear": 0.01 * scale}
    file.add("cameras", type="perspective", perspective=view)
    eye = file.add("nodes", camera=0, matrix=inside.to_world.T.ravel().tolist())
    rotated = file.mesh_node(*primitives, rotation=TURN, children=[eye])
    root = file.add("nodes", children=[rotated], scale=[scale] * 3, translation=list(offset))
    file.add("scenes", nodes=[root])
    return DeviceScene(file.load(), device)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("rooms")


@pytest.fixture(scope="module")
def plain(folder: Path, device: str) -> dict[Method, Floats]:
    """The pictures of the room as it is."""
    device_scene = room(folder, device, 1.0, (0.0, 0.0, 0.0))
    return {m: render(device_scene, device_scene.scene.cameras[0], SIZE, method=m, samples=4) for m in Method}


@settings(max_examples=2, deadline=None, derandomize=True)
@given(exponent=st.floats(-6.0, 6.0), extents=st.tuples(EXTENTS, EXTENTS, EXTENTS))
@example(exponent=-6.0, extents=(0.0, 0.0, 0.0))
@example(exponent=6.0, extents=(1e6, -1e6, 1e6))
@example(exponent=-6.0, extents=(-1e6, 1e6, 1e6))
def test_scale_and_place_change_nothing(
    folder: Path,
    device: str,
    plain: dict[Method, Floats],
    exponent: float,
    extents: tuple[float, float, float],
) -> None:
    scale = 10.0**exponent
    device_scene = room(folder, device, scale, [scale * extent for extent in extents])
    for method, expected in plain.items():
        picture = render(device_scene, device_scene.scene.cameras[0], SIZE, method=method, samples=4)
        assert rel_mse(picture, expected) < 1e-6, method


def test_there_is_something_to_change(plain: dict[Method, Floats]) -> None:
    for picture in plain.values():
        assert (picture > 0.0).mean() > 0.99
        assert picture.std() > 0.1 * picture.mean()
