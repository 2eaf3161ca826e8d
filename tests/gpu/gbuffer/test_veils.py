"""What cameras see of surfaces that are there in part, and what behind them."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import camera_of, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import LIKELIER, chain_samples
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import AlphaMode, Doubles, Material, Sky

SIZE = (8, 6)
CAMERA = look_at((0.0, 0.1, 1.5), (0.0, 0.0, 0.0), yfov_degrees=20.0)
PANE = Material(transmission=1.0, roughness=0.0)
MIRROR = Material(metallic=1.0, roughness=0.0)


def veil(alpha: float, albedo: float = 0.3, emission: float = 0.0) -> Material:
    plain = grey(albedo, emission)
    return replace(plain, base_color=(albedo, albedo, albedo, alpha), alpha_mode=AlphaMode.BLEND, double_sided=True)


def sheet(z: float, material: int) -> MeshPart:
    return quad([-2.0, -2.0, z], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], material)


def seen(
    device_scene: DeviceScene, moment: int = LIKELIER, *, splits: bool = True, features: SceneFeatures = EVERYTHING
) -> dict[str, Doubles]:
    """Of each pixel, what its G-buffer says of the end of its chain."""
    gbuffer = allocate(GBuffer, SIZE[0] * SIZE[1], device_scene.device)
    gbuffer.chains, samples = True, chain_samples(device_scene.device, moment)
    samples.splits = splits
    scene = device_scene.view(lambertian=False)
    trace_primary_rays(scene, camera_of(device_scene, CAMERA, SIZE), SIZE, gbuffer, samples, features)
    return {name: getattr(gbuffer, name).numpy()[..., 0].astype(float) for name in ("albedo", "throughput", "emitted")}


def wall_behind(*veils: Material, before: Material | None = None) -> DeviceScene:
    """Veils one behind the other, maybe with something before them, and a wall that reflects 0.8 behind."""
    parts = [sheet(0.1 * (len(veils) - k), k + 1) for k in range(len(veils))]
    parts += [sheet(0.9, len(veils) + 1)] if before else []
    return resident_of([sheet(-0.5, 0), *parts], [grey(0.8), *veils, *([before] if before else [])])


@pytest.mark.parametrize(("alpha", "albedo", "share"), [(0.2, 0.8, 0.8), (0.7, 0.3, 0.7)])
def test_the_likelier_of_a_veil_and_what_is_behind_counts_by_its_share(
    alpha: float, albedo: float, share: float
) -> None:
    found = seen(wall_behind(veil(alpha)))
    assert np.allclose(found["albedo"], albedo)
    assert np.allclose(found["throughput"], share)


@pytest.mark.parametrize("alpha", [0.2, 0.7])
def test_where_one_branch_is_shown_it_counts_for_both(alpha: float) -> None:
    assert np.allclose(seen(wall_behind(veil(alpha)), splits=False)["throughput"], 1.0)


def test_kernels_without_sheer_veils_show_the_others_alike() -> None:
    told, bare = replace(EVERYTHING, sheer=False), wall_behind()
    for alpha in (0.2, 0.7):
        device_scene = wall_behind(veil(alpha))
        found = [seen(device_scene, features=features)["throughput"] for features in (EVERYTHING, told)]
        assert (found[0] == found[1]).all() == (alpha > 0.5)
    assert (seen(bare, features=told)["albedo"] == seen(bare)["albedo"]).all()


def test_only_the_first_veil_of_a_way_is_shown_in_part() -> None:
    assert np.allclose(seen(wall_behind(veil(0.2), veil(0.4)))["throughput"], 0.8)
    both = seen(wall_behind(veil(0.2), veil(0.7, albedo=0.4)))
    assert np.allclose(both["throughput"], 0.8)
    assert np.allclose(both["albedo"], 0.4)


def test_of_a_veil_behind_a_pane_all_is_seen_or_nothing() -> None:
    for alpha, albedo in ((0.2, 0.8), (0.7, 0.3)):
        through = seen(wall_behind(veil(alpha), before=PANE))
        alone = seen(wall_behind(before=PANE))
        assert np.allclose(through["albedo"], albedo)
        assert np.allclose(through["throughput"], alone["throughput"])


def test_veils_are_seen_in_mirrors() -> None:
    parts = [sheet(-0.5, 0), sheet(0.6, 1), sheet(2.0, 2)]
    found = seen(resident_of(parts, [MIRROR, veil(0.2), grey(0.6)]))
    direct = seen(resident_of([parts[0], sheet(2.0, 1)], [MIRROR, grey(0.6)]))
    assert np.allclose(found["albedo"], 0.6)
    # Its first veil is the one on the way to the mirror.
    assert np.allclose(found["throughput"], 0.8 * direct["throughput"])


def test_before_nothing_but_the_sky_a_faint_veil_is_what_is_shaded() -> None:
    device_scene = resident_of([sheet(0.0, 0)], [veil(0.2)], sky=Sky((2.0, 2.0, 2.0)))
    found = seen(device_scene)
    assert np.allclose(found["albedo"], 0.3)
    assert np.allclose(found["throughput"], 0.2)
    assert np.allclose(found["emitted"], 0.0)  # the other branch has the sky


def test_what_a_veil_emits_counts_by_its_share() -> None:
    assert np.allclose(seen(wall_behind(veil(0.7, emission=2.0)))["emitted"], 1.4)
    assert np.allclose(seen(wall_behind(veil(0.3, emission=2.0)))["emitted"], 0.0)  # the other branch has it


@pytest.mark.parametrize("alpha", [0.2, 0.7])
def test_drawn_chains_meet_a_veil_as_often_as_it_is_there(alpha: float) -> None:
    device_scene = wall_behind(veil(alpha))
    found = [seen(device_scene, moment) for moment in range(64)]
    assert all(np.allclose(one["throughput"], 1.0) for one in found)
    met = np.mean([one["albedo"] == np.float32(0.3) for one in found])
    assert met == pytest.approx(alpha, abs=0.03)
