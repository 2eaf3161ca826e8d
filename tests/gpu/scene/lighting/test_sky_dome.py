"""Which shells around a scene are its sky."""

from collections.abc import Sequence

import numpy as np
import pytest
from scenes import box, quad
from trimesh.creation import icosphere

from gpu.scene.assemble import assemble
from gpu.scene.lighting.sky_dome import sky_notes, with_sky_dome
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Light, LightKind, Material, Scene

GROUND = quad([-20, 0, -20], [0, 0, 40], [40, 0, 0], 0)
HOUSE = [MeshPart(part.positions * 4.0 + [3.0, 2.0, 0.0], part.triangles) for part in box()]
LABEL = quad([3, 1, 2.1], [1, 0, 0], [0, 1, 0], 2)
SKY = Material("sky", unlit=True)
GLOW = Material("glow", emission=(1.0, 1.0, 1.0))
SUN = Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, -1.0, 0.0))


def ball(radius: float, material: int = 1, *, upper: bool = False, aside: float = 0.0) -> MeshPart:
    mesh = icosphere(3, radius)
    faces = mesh.faces[:, ::-1]
    if upper:
        faces = faces[mesh.triangles_center[:, 1] > -0.02 * radius]
    middle = np.array([aside, 0.0, 0.0])
    return MeshPart(np.asarray(mesh.vertices) + middle, np.asarray(faces), material=material)


def backdrops(parts: Sequence[MeshPart], materials: Sequence[Material], *, sun: bool = False) -> list[int]:
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    triangles = np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=False)])
    material = np.repeat([part.material for part in parts], [len(part.triangles) for part in parts])
    found = with_sky_dome(np.concatenate([p.positions for p in parts]), triangles, material, materials, sun=sun)
    assert len(found) == len(materials)
    return [number for number, made in enumerate(found) if made.backdrop]


@pytest.mark.parametrize(
    "shell",
    [
        [ball(60.0)],
        [ball(3000.0)],
        [ball(30.0, upper=True)],
        [ball(28.0, upper=True)],  # the corners of the ground stand out a little
        [MeshPart(part.positions * 100.0, part.triangles, material=1) for part in box()],
    ],
)
def test_unlit_shells_are_the_sky_whatever_their_shape_and_size(shell: list[MeshPart]) -> None:
    assert backdrops([GROUND, *HOUSE, *shell], [Material(), SKY]) == [1]


def test_a_sky_box_of_six_pictures_is_one() -> None:
    faces = [MeshPart(part.positions * 100.0, part.triangles, material=1 + k) for k, part in enumerate(box())]
    assert backdrops([GROUND, *HOUSE, *faces], [Material(), *[SKY] * 6]) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize(
    ("parts", "materials"),
    [
        ([GROUND, *HOUSE, ball(60.0)], [Material(), Material()]),  # lit as all else
        ([GROUND, *HOUSE, ball(2.0)], [Material(), SKY]),  # within
        ([GROUND, *HOUSE, ball(60.0, aside=100.0)], [Material(), SKY]),  # beside
        ([ball(60.0)], [Material(), SKY]),  # alone
        ([GROUND, *HOUSE, ball(60.0)], [SKY, SKY]),  # all is unlit
        ([GROUND, *HOUSE, quad([-20, 5, -20], [40, 0, 0], [0, 0, 40], 1)], [Material(), SKY]),  # a ceiling
    ],
)
def test_other_things_are_not(parts: list[MeshPart], materials: list[Material]) -> None:
    assert backdrops(parts, materials, sun=True) == []


def test_emissive_shells_are_where_they_would_shut_the_sun_out() -> None:
    parts = [GROUND, *HOUSE, ball(60.0)]
    assert backdrops(parts, [Material(), GLOW], sun=True) == [1]
    assert backdrops(parts, [Material(), GLOW]) == []


def test_what_is_unlit_within_stays_where_it_is() -> None:
    assert backdrops([GROUND, *HOUSE, LABEL, ball(60.0)], [Material(), SKY, Material(unlit=True)]) == [1]


def assembled(*lights: Light, dome: Material = SKY) -> Scene:
    return assemble("town", SceneParts([GROUND, *HOUSE, ball(3000.0)], [Material(), dome], (), lights))


def test_a_sky_sets_neither_scale_nor_bounds_nor_view() -> None:
    scene = assembled()
    assert scene.placement.scale == pytest.approx(1.0 / 40.0)
    assert np.allclose(scene.bounds, ((-20.0, 0.0, -20.0), (20.0, 4.0, 20.0)))
    assert np.abs(scene.cameras[0].to_world[:3, 3]).max() < 60.0
    assert np.abs(scene.vertices).max() == pytest.approx(75.0, rel=0.01)


def test_the_report_says_so() -> None:
    assert sky_notes(assembled().materials) == [assembled().report.notes[0]]
    assert "the sky around the scene, 'sky', is shown behind it and stops no light" in assembled().report.notes[0]
    assert any("soft sky" in note for note in assembled().report.notes)
    assert not any("soft sky" in note for note in assembled(SUN, dome=GLOW).report.notes)
