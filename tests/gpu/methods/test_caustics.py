from typing import Any

import pytest
from glass import EVEN, FLOOR, GLASS, ball, cube
from scenes import box, grey, quad, resident_of
from stage_order import noted_stages

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.methods.caustics import radius_share
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Camera, Floats
from gpu.settings import Method, RenderSettings

FEW: dict[str, Any] = {"vpls": 300, "sp_clusters": 40, "vpl_clusters": 20, "photons": 500, "gather_rays": 8}
FEW |= {"caustic_photons": 4096, "shadow_map": 64, "smooth": False}


def below(x: float) -> Camera:
    """Between what hangs over the floor and this."""
    return Camera("below", look_at((x, -0.15, 0.0), (x, -0.25, 0.0), (0.0, 0.0, 1.0)).to_world, 0.2, orthographic=True)


BELOW, MOVED = below(0.0), below(0.004)
SIZE = 24, 24


def picture(scene: DeviceScene, camera: Camera, **settings: Any) -> Floats:
    return Renderer(scene, SIZE, RenderSettings.model_validate(FEW | settings)).render(camera).radiance()


@pytest.mark.parametrize("thing", ["ball", "cube"])
def test_glass_takes_no_light_from_a_floor_in_an_even_environment(thing: str) -> None:
    """Its shadow is as dark as its caustic is bright."""
    parts = [ball()] if thing == "ball" else cube()
    scene = resident_of([*parts, FLOOR], [GLASS, grey(0.01)], sky=EVEN).generalised()
    settings = {"method": "exact-vpl", "samples": 64, "bounces": 12, "caustic_photons": 16_384, "near_field": False}
    full = picture(scene, BELOW, **settings) / 0.01
    direct = picture(scene, BELOW, component="direct", **settings) / 0.01
    middle = slice(8, 16), slice(8, 16)
    assert direct[middle].mean() < 0.88
    assert full[middle].mean() == pytest.approx(1.0, abs=0.04)
    assert full.mean() == pytest.approx(1.0, abs=0.03)


def lit_glass(block: list[MeshPart]) -> DeviceScene:
    """A block on the dark floor of a dark room, under a lamp so large that paths find it."""
    lamp = quad([-0.3, 0.49, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6], 2)
    return resident_of([*block, *box(1), lamp], [GLASS, grey(0.05), grey(0.0, 5.0)])


def test_caustics_bring_as_much_light_as_paths_find() -> None:
    block = [MeshPart(part.positions - [0.0, 0.395, 0.0], part.triangles) for part in cube()]
    scene, above = lit_glass(block).generalised(), look_at((0.3, 0.0, 0.3), (0.0, -0.45, 0.0), yfov_degrees=50.0)
    # Of a path's bounces some are of the glass that the camera looks through.
    path = picture(scene, above, method="path", samples=256, bounces=10)
    full = picture(scene, above, method="exact-vpl", samples=32, bounces=10, caustic_photons=16_384)
    assert full.mean() == pytest.approx(path.mean(), rel=0.05)


def test_estimates_narrow_at_rest() -> None:
    assert radius_share(0) == 1.0
    assert radius_share(1) == pytest.approx((5.0 / 6.0) ** 0.5)
    assert radius_share(1000) == pytest.approx(radius_share(125) / 2.0**0.5, rel=0.01)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL, Method.PHOTON_GATHER, Method.RSM_DISKS])
def test_every_method_shows_caustics_and_keeps_them_while_light_does_not_change(method: Method) -> None:
    scene = lit_glass(cube()).generalised()
    few = FEW | {"method": method, "vpls": 50, "caustic_photons": 256}
    renderer = Renderer(scene, SIZE, RenderSettings.model_validate(few))
    first = renderer.render(BELOW)
    assert first.stats.counts["caustic_photons"] > 20
    assert {"caustic-photons", "caustics"} <= set(first.stats.stage_ms)
    assert "caustic-photons" not in renderer.render(MOVED, walks=True).stats.stage_ms
    rest = Accumulation(SIZE[0] * SIZE[1], scene.device)
    traced = ["caustic-photons" in renderer.render(MOVED, rest).stats.stage_ms for _ in range(3)]
    assert traced == [False, True, True]
    direct = Renderer(scene, SIZE, RenderSettings.model_validate(few | {"component": "direct"})).render(BELOW)
    assert "caustics" not in direct.stats.stage_ms


def test_they_are_gathered_beside_what_does_not_show_them(monkeypatch: pytest.MonkeyPatch) -> None:
    begun = noted_stages(monkeypatch)
    few = FEW | {"vpls": 50, "caustic_photons": 256, "smooth": True}
    Renderer(lit_glass(cube()).generalised(), (256, 200), RenderSettings.model_validate(few)).render(BELOW)
    assert begun[:4] == ["gbuffer", "caustic-photons", "caustics points", "direct rays"]
    assert begun.index("shade") < begun.index("caustics between") < begun.index("correct")
    assert begun.index("caustics waits") == begun.index("direct waits") + 1


def test_matt_scenes_pay_nothing() -> None:
    room = resident_of([*box(), quad([-0.2, 0.49, -0.2], [0.4, 0, 0], [0, 0, 0.4], 1)], [grey(0.5), grey(0.0, 5.0)])
    camera = look_at((0.0, 0.0, 0.4), (0.0, -0.2, -0.5))
    renderer = Renderer(room, SIZE, RenderSettings.model_validate(FEW))
    frame = renderer.render(camera)
    assert not {"caustic-photons", "caustics"} & set(frame.stats.stage_ms)
    assert "caustic_photons" not in frame.stats.counts
