import numpy as np
import warp as wp
from scenes import column, strewn_vpls
from shadow_maps import maps_of

from gpu.core.device import allocate
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer
from gpu.scene.types import Doubles
from gpu.vpl.bidirectional_importance import (
    BIDIRECTIONAL_IMPORTANCE_PARAMETERS,
    VIEW_SAMPLES,
    BidirectionalImportance,
)

CPU = wp.get_device("cpu")
SIZE = (64, 48)


def gbuffer_of(rng: np.random.Generator) -> GBuffer:
    """Pixels that see points anywhere; every third sees nothing."""
    count = SIZE[0] * SIZE[1]
    gbuffer: GBuffer = allocate(GBuffer, count, CPU)
    gbuffer.position = column(rng.uniform(-0.5, 0.5, (count, 3)), wp.vec3)
    normal = rng.normal(size=(count, 3))
    gbuffer.normal = column(normal / np.linalg.norm(normal, axis=1, keepdims=True), wp.vec3)
    gbuffer.face = column(np.where(np.arange(count) % 3 == 0, int(NO_HIT), 0), wp.int32)
    return gbuffer


def inverse(index: int, base: int) -> float:
    value, digit = 0.0, 1.0
    while index:
        digit /= base
        value, index = value + digit * (index % base), index // base
    return value


def geometry_terms(position: Doubles, normal: Doubles, others: Doubles, other_normals: Doubles) -> Doubles:
    """cosθ·cosθ′ / (d²·(π·d² + A)) · d² of pairs, (point, other)."""
    area = BIDIRECTIONAL_IMPORTANCE_PARAMETERS.area
    way = others[None] - position[:, None]
    squared = (way**2).sum(axis=2)
    facing = np.maximum((way * normal[:, None]).sum(axis=2), 0.0)
    leaving = np.maximum(-(way * other_normals[None]).sum(axis=2), 0.0)
    return np.asarray(facing * leaving / (squared * (np.pi * squared + area)))


def test_importance_is_flux_times_the_mean_geometry_term_of_halton_s_pixels() -> None:
    vpls, gbuffer = strewn_vpls(200, 0.1, 0), gbuffer_of(np.random.default_rng(1))
    vpls.flux = column(np.where(np.arange(200)[:, None] % 5 == 0, 0.0, vpls.flux.numpy()), wp.vec3)
    importance = wp.zeros(200, dtype=float, device=CPU)
    maps = maps_of(4)
    maps.side = 8
    maps.worth.assign([1.0, 0.25, 1.0, 1.0])
    BidirectionalImportance(CPU).run(gbuffer, SIZE, maps, vpls, importance)
    points = [(inverse(number, 2), inverse(number, 3)) for number in range(1, VIEW_SAMPLES + 1)]
    pixels = [int(y * SIZE[1]) * SIZE[0] + int(x * SIZE[0]) for x, y in points]
    position, normal = gbuffer.position.numpy()[pixels], gbuffer.normal.numpy()[pixels]
    seen = gbuffer.face.numpy()[pixels] != int(NO_HIT)
    terms = geometry_terms(position, normal, vpls.position.numpy(), vpls.normal.numpy())
    mean = (terms * seen[:, None]).mean(axis=0)
    expected = vpls.flux.numpy().mean(axis=1) * (mean + 0.02)
    expected[64:128] *= 0.25  # those of the second map
    assert np.allclose(importance.numpy(), expected, rtol=1e-4)
    assert (importance.numpy()[::5] == 0.0).all()


def test_what_is_near_has_no_importance_without_bound() -> None:
    """A VPL close above a point: its term is at most 1/A, which is 100."""
    vpls, gbuffer = strewn_vpls(1, 0.0, 0), gbuffer_of(np.random.default_rng(1))
    gbuffer.face.fill_(0)
    gbuffer.position.fill_(wp.vec3(0.0, 0.0, 0.0))
    gbuffer.normal.fill_(wp.vec3(0.0, 1.0, 0.0))
    vpls.position.fill_(wp.vec3(0.0, 1e-3, 0.0))
    vpls.normal.fill_(wp.vec3(0.0, -1.0, 0.0))
    vpls.flux.fill_(wp.vec3(1.0, 1.0, 1.0))
    importance = wp.zeros(1, dtype=float, device=CPU)
    BidirectionalImportance(CPU).run(gbuffer, SIZE, maps_of(), vpls, importance)
    assert 95.0 < importance.numpy()[0] < 101.0
