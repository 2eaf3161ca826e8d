"""What glass and veils show by both of their branches: in an evenly lit room, as much as there is."""

from dataclasses import replace

import numpy as np
import pytest
from frame_view import FrameView
from scenes import box, grey, quad, resident_of

from gpu.indirect.lobe_light import KnownLight, known_light
from gpu.indirect.other_branch import OtherBranch
from gpu.scene.camera import look_at
from gpu.scene.types import AlphaMode, Doubles, Material, Sky
from gpu.vpl.light_sets import LightSetChoice, LightSets

SIZE = (24, 16)
CAMERA = look_at((0.2, 0.1, 0.3), (0.0, 0.0, -0.05), yfov_degrees=25.0)


def add_other(view: FrameView, known: KnownLight) -> None:
    """Add what the other branch shows to a view's radiance."""
    frame, other = view.frame, OtherBranch(SIZE, view.frame.device)
    other.find(frame.scene, view.camera, frame.chain_samples, frame.gbuffer, known, frame.features)
    other.add(view.radiance)


def seen(material: Material, seed: int = 0) -> tuple[Doubles, Doubles]:
    """Of a plate in a room whose walls emit 1/π and reflect half: the throughput of the likelier branch, and
    what the other adds to it, in parts of the light there is; (pixel,) each.
    """
    thickness = material.thickness
    front = quad([-0.49, -0.49, 0.0], [0.98, 0, 0], [0, 0.98, 0], 1)
    back = quad([-0.49, -0.49, -thickness], [0, 0.98, 0], [0.98, 0, 0], 1)
    parts = [*box(), front, back][: 8 if thickness else 7]
    device_scene = resident_of(parts, [grey(0.5, emission=1.0 / np.pi), material]).generalised()
    lights = LightSets(device_scene)
    choice = LightSetChoice(vpls=20_000, vpl_clusters=200, bounces=8, seed=seed, lambertian=False)
    cache = lights.radiosity(lights.made(choice, lambda what, fraction: None))
    view = FrameView(device_scene, SIZE, lambertian=False, traces_lobes=True)
    view.chain_samples.splits = True
    view.set_camera(CAMERA)
    view.find_shading_points()
    frame, known = view.frame, known_light(lights.table, cache, direct=True)
    add_other(view, known)
    return frame.gbuffer.throughput.numpy()[:, 0].astype(float), view.radiance.numpy()[:, 0] * np.pi / 2.0


@pytest.mark.parametrize("thickness", [0.0, 0.02])
def test_both_branches_show_all_the_light(thickness: float) -> None:
    """Half of it is emitted, which is exact; the rest is as noisy as VPLs are."""
    likelier, other = seen(Material(transmission=1.0, roughness=0.0, thickness=thickness))
    assert 0.01 < other.mean() < 0.2
    assert np.ptp(likelier) > 0.01
    assert (likelier + other).mean() == pytest.approx(1.0, abs=0.01)
    assert likelier + other == pytest.approx(np.ones(SIZE[0] * SIZE[1]), abs=0.2)


@pytest.mark.parametrize("alpha", [0.2, 0.7])
def test_both_branches_show_all_the_light_at_a_veil(alpha: float) -> None:
    """Such as reflects half and emits as the walls do."""
    veil = replace(grey(0.5, emission=1.0 / np.pi), base_color=(0.5, 0.5, 0.5, alpha), alpha_mode=AlphaMode.BLEND)
    likelier, other = np.mean([seen(replace(veil, double_sided=True), seed) for seed in range(4)], axis=0)
    assert likelier == pytest.approx(np.full(SIZE[0] * SIZE[1], max(alpha, 1.0 - alpha)))
    assert other.mean() == pytest.approx(min(alpha, 1.0 - alpha), rel=0.06)
    assert likelier + other == pytest.approx(np.ones(SIZE[0] * SIZE[1]), abs=0.2)


def test_the_other_branch_of_a_faint_veil_before_the_sky_is_the_sky() -> None:
    veil = Material(base_color=(0.5, 0.5, 0.5, 0.2), alpha_mode=AlphaMode.BLEND)
    sheet = quad([-2.0, -2.0, -0.3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])
    view = FrameView(resident_of([sheet], [veil], sky=Sky((2.0, 2.0, 2.0))), SIZE, lambertian=False, traces_lobes=True)
    view.chain_samples.splits = True
    view.set_camera(CAMERA)
    view.find_shading_points()
    known = known_light(LightSets(view.device_scene).table, None, direct=True)
    add_other(view, known)
    up = -view.gbuffer.to_camera.numpy()[:, 1:2]
    assert np.allclose(view.radiance.numpy(), 0.8 * (1.0 + up), atol=1e-5)


def test_behind_a_veil_backs_are_seen_through_as_before_it() -> None:
    veil = Material(base_color=(0.5, 0.5, 0.5, 0.7), alpha_mode=AlphaMode.BLEND)
    back = quad([-2.0, -2.0, -0.5], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], 1)
    sheet = quad([-2.0, -2.0, -0.3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])
    one_sided = Material(emission=(9.0, 9.0, 9.0), double_sided=False)
    device_scene = resident_of([sheet, back], [veil, one_sided], sky=Sky((2.0, 2.0, 2.0)))
    view = FrameView(device_scene, SIZE, lambertian=False, traces_lobes=True)
    view.chain_samples.splits = True
    view.set_camera(CAMERA)
    view.find_shading_points()
    known = known_light(LightSets(device_scene).table, None, direct=True)
    add_other(view, known)
    up = -view.gbuffer.to_camera.numpy()[:, 1:2]
    assert np.allclose(view.radiance.numpy(), 0.3 * (1.0 + up), atol=1e-5)


def test_where_there_is_no_glass_a_coat_has_no_other_branch() -> None:
    """Also by kernels for scenes that may have some."""
    likelier, other = seen(Material(clearcoat=1.0))
    assert likelier.max() < 1.0
    assert np.all(other == 0.0)
