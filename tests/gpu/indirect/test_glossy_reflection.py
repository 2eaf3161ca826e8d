"""What rays of specular lobes find in evenly lit rooms, and what pixels share of it, in closed form."""

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import box, grey, quad, resident_of
from walls import CPU, HEIGHT, LEFT, WIDTH, grey_values, numbers, wall

from gpu.core.device import launch
from gpu.core.image_size import image_size
from gpu.direct.direct_light import direct_samples
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.glossy_reflection import (
    GLOSS_PARAMETERS,
    GlossyReflection,
    bound_fireflies_kernel,
    share_gloss_kernel,
)
from gpu.indirect.lobe_light import known_light
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Floats, Material
from gpu.vpl.light_sets import LightSetChoice, LightSets

SIZE = (24, 16)
CAMERA = look_at((0.0, 0.0, 0.3), (0.0, 0.0, -0.3), yfov_degrees=30.0)


class Room:
    """A metal plate in a room whose walls emit 1/π and reflect half: evenly lit, they reflect 1/π, too."""

    def __init__(self, roughness: float, size: tuple[int, int] = SIZE) -> None:
        plate = quad((-0.3, -0.3, -0.3), (0.6, 0.0, 0.0), (0.0, 0.6, 0.0), 1)
        metal = Material(base_color=(0.9, 0.7, 0.5, 1.0), metallic=1.0, roughness=roughness)
        device_scene = resident_of([*box(), plate], [grey(0.5, emission=1.0 / np.pi), metal]).generalised()
        choice = LightSetChoice(vpls=20_000, vpl_clusters=200, bounces=8, seed=0, lambertian=False)
        lights = LightSets(device_scene)
        self.cache = lights.radiosity(lights.made(choice, lambda what, fraction: None))
        self.view = FrameView(device_scene, size, lambertian=False, traces_lobes=True)
        self.view.set_camera(CAMERA)
        self.view.find_shading_points()
        assert self.view.gloss
        self.gloss: GlossyReflection = self.view.gloss
        self.known = known_light(lights.table, self.cache, direct=True)
        self.trace()

    def trace(self, frames: int | None = None) -> Floats:
        """What is found where light is known of so many `frames`; `light` after it."""
        moment, seen_by = wp.zeros(1, dtype=int, device=CPU), (self.view.scene, self.view.camera, self.view.gbuffer)
        before = None if frames is None else wp.full(SIZE[0] * SIZE[1], frames, dtype=int, device=CPU)
        self.gloss.trace(*seen_by, self.known, direct_samples(1, moment, 0, None, before, settled=5))
        return self.light()

    def light(self) -> Floats:
        return np.array(self.gloss.light.numpy())


@pytest.fixture(scope="module")
def room() -> Room:
    return Room(0.2)


def test_lobes_find_the_light_around_and_share_it(room: Room) -> None:
    """What they reflect of it is known up to the fit of `even_reflectance`."""
    found = room.light()
    assert found.mean(axis=0) * np.pi == pytest.approx(np.ones(3), abs=0.1)
    room.gloss.share(room.view.gbuffer, restores=False)
    assert room.light().mean() == pytest.approx(found.mean(), rel=0.02)
    assert room.light().std() < 0.6 * found.std()


def test_what_is_cut_off_of_rare_bright_rays_is_given_to_the_surface_around() -> None:
    """One ray in thirteen that finds all of the light, as among metals."""
    room = Room(0.2, (75, 50))
    found = np.full((75 * 50, 3), 0.1, np.float32)
    found[::13] = 13.0
    lit = {}
    for restores in (False, True):
        room.gloss.light.assign(found)
        room.gloss.share(room.view.gbuffer, restores=restores)
        lit[restores] = room.light()
    assert lit[False].mean() < 0.7 * found.mean()
    assert lit[True].mean() == pytest.approx(found.mean(), rel=0.1)
    assert lit[True].std() < 0.3 * found.std()


def test_of_rows_whose_light_is_known_each_second_has_that_of_the_rows_beside() -> None:
    """But for those at the picture's rim and beside another surface, and where light is known of fewer frames."""
    room = Room(0.2)
    room.view.gbuffer.roughness.assign(np.repeat([0.2, 0.3], SIZE[0] * SIZE[1] // 2).astype(np.float32))
    each = room.trace()
    assert (room.trace(frames=4) == each).all()
    found, own = (light.reshape(SIZE[1], SIZE[0], 3) for light in (room.trace(frames=5), each))
    between = [row for row in range(1, SIZE[1] - 1, 2) if row != SIZE[1] // 2 - 1]
    others = [row for row in range(SIZE[1]) if row not in between]
    assert (found[others] == own[others]).all()
    beside = (own[[row - 1 for row in between]] + own[[row + 1 for row in between]]) / 2.0
    assert np.allclose(found[between], beside)
    assert not np.allclose(own[between], beside)


def test_what_lobes_look_for_is_no_part_of_even_light(room: Room) -> None:
    assert np.allclose(room.view.gbuffer.albedo.numpy(), 0.0, atol=1e-6)
    radiance = wp.zeros(SIZE[0] * SIZE[1], dtype=wp.vec3, device=CPU)
    room.gloss.light.fill_(1.0)
    room.gloss.add(room.view.gbuffer, radiance)
    assert radiance.numpy().mean(axis=0) == pytest.approx([0.9, 0.7, 0.5], rel=0.05)


def test_lobes_reach_as_far_as_they_are_wide(room: Room) -> None:
    """Half the lobe's width where the ray ends, less what the pixels' own rays spread up to there."""
    scale = room.view.device_scene.scene.placement.scale
    middle = (SIZE[1] // 2) * SIZE[0] + SIZE[0] // 2
    reach = room.gloss._found.reach.numpy()[middle] / scale
    # From 0.6 before the plate, its middle sees the wall 0.8 before it, about.
    assert reach == pytest.approx(0.5 * (2.0 * 0.2**2) * 0.8 * 0.6 / (0.8 + 0.6), rel=0.15)


def shared(gbuffer: GBuffer, reach: float, light: Doubles) -> Doubles:
    """`light` (HEIGHT, WIDTH) after one step of sharing with the pixels beside."""
    out = wp.zeros(WIDTH * HEIGHT, dtype=wp.vec3, device=CPU)
    reaches = wp.full(WIDTH * HEIGHT, reach, dtype=float, device=CPU)
    inputs = [gbuffer, image_size((WIDTH, HEIGHT)), 1, GLOSS_PARAMETERS, reaches, grey_values(light), out]
    launch(share_gloss_kernel, WIDTH * HEIGHT, inputs, CPU)
    return np.asarray(numbers(out))


def test_pixels_share_by_roughness_and_plane() -> None:
    """Beside an edge four of sixteen parts come from the other side, each by 1/e where that differs by a tolerance."""
    rough = np.where(LEFT, 0.2, 0.25).ravel().astype(np.float32)
    rougher, behind = wall(), wall(depth=np.where(LEFT, 0.0, 0.5))
    rougher.roughness.assign(rough)
    for gbuffer in (rougher, behind):
        mixed = shared(gbuffer, 100.0, np.where(LEFT, 0.0, 1.0))
        part = 4.0 * np.exp(-1.0) / (12.0 + 4.0 * np.exp(-1.0))
        assert mixed[5:-5, WIDTH // 2 - 1] == pytest.approx(part, rel=0.05)


def test_narrow_lobes_are_not_shared() -> None:
    light = np.where(LEFT, 0.0, 1.0)
    assert (shared(wall(), 0.5, light) == light).all()
    assert shared(wall(), 2.0, light)[20, WIDTH // 2 - 1] == pytest.approx(0.25, rel=0.02)
    assert (shared(wall(), 0.0, light) == light).all()


def test_sparks_are_bounded_by_the_pixels_around_and_edges_stay() -> None:
    """One pixel; those beside a bright half stay, and so does one that no other ray is near."""

    def bounded(light: Doubles, reach: Doubles) -> Doubles:
        out = wp.zeros(WIDTH * HEIGHT, dtype=wp.vec3, device=CPU)
        reaches = wp.array(reach.ravel(), dtype=float, device=CPU)
        inputs = [image_size((WIDTH, HEIGHT)), GLOSS_PARAMETERS, reaches, grey_values(light), out]
        launch(bound_fireflies_kernel, WIDTH * HEIGHT, inputs, CPU)
        return np.asarray(numbers(out))

    everywhere, light = np.ones((HEIGHT, WIDTH)), np.where(LEFT, 1.0, 5.0)
    assert (bounded(light, everywhere) == light).all()
    light[4, 3] = 50.0
    assert bounded(light, everywhere)[4, 3] == pytest.approx(2.0)
    alone = np.zeros((HEIGHT, WIDTH))
    alone[4, 3] = 1.0
    assert (bounded(light, alone) == light).all()
