"""What a device does in a second: rays of a scene, bytes, arithmetic and launches, each measured alone.

Rays are timed as a frame traces them, neighbouring threads on neighbouring shading points, by the renderer's own
functions: these are the best that a stage of such rays could reach.
"""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import warp as wp

from gpu.core.device import allocate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.morton import morton_order
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import closest_hit, connection
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import CameraData, camera_data, pixel_ray
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import chain_samples
from gpu.methods.light_making import light_set_choice
from gpu.methods.method import RenderSetup
from gpu.sample_counts import sample_counts_of
from gpu.scene.types import Ints
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets
from tests.bench.figures import spread
from tests.bench.subjects import Size

REPEATS = 9
FAR = wp.constant(1.0e6)
# Of a thread's fused multiply-adds, so many are independent of each other.
CHAINS = 8
LAUNCHES = 500
# A CPU gets so much less of what has no size of its own.
CPU_SHARE = 256


@dataclass(frozen=True)
class Rates:
    """A second's worth: bytes read or written, fused multiply-adds, launches of a graph, and rays of one scene.

    any_hit_rays: between facing shading points and VPL clusters; primary_rays: to the first hit, through the pixels.
    """

    bytes: float
    fmas: float
    launches: float
    any_hit_rays: float
    primary_rays: float


@wp.kernel
def fma_kernel(first: int, rounds: int, values: wp.array[float]) -> None:
    """One thread a number: CHAINS multiply-adds a round, all in registers."""
    index = first + wp.tid()
    x = values[index]
    a, b, c, d = x + 1.0, x + 2.0, x + 3.0, x + 4.0
    e, f, g, h = x + 5.0, x + 6.0, x + 7.0, x + 8.0
    for _round in range(rounds):
        a = a * x + b
        b = b * x + c
        c = c * x + d
        d = d * x + e
        e = e * x + f
        f = f * x + g
        g = g * x + h
        h = h * x + x
    values[index] = a + b + c + d + e + f + g + h


@wp.kernel
def empty_kernel(first: int) -> None:
    """One thread: nothing."""
    _index = first + wp.tid()


@wp.kernel
def primary_kernel(first: int, scene: SceneData, cameras: wp.array[CameraData], image: ImageSize,
                   distance: wp.array[float]) -> None:  # fmt: skip
    """One thread a pixel: how far its ray goes."""
    pixel = first + wp.tid()
    ray = pixel_ray(cameras[0], pixel, image)
    distance[pixel] = closest_hit(scene, ray.origin, ray.direction, FAR).t


def any_hit_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.device_scene.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        pairs: wp.array[int],
        sp_count: int,
        sps: wp.array2d[wp.vec3],
        vpls: wp.array2d[wp.vec3],
        seen: wp.array[wp.uint8],
    ) -> None:
        """One thread a pair, vpl · sp_count + sp: whether they see each other. sps, vpls: (position or normal, i)."""
        index = first + wp.tid()
        sp = pairs[index] % sp_count
        vpl = pairs[index] // sp_count
        sees = connect(scene, sps[0, sp], sps[1, sp], vpls[0, vpl], vpls[1, vpl])
        seen[index] = wp.uint8(wp.where(sees, 1, 0))

    return kernel


def seconds_of(work: Callable[[], None], device: wp.Device, repeats: int = REPEATS) -> float:
    """Median time of `work` after a first run, on CUDA as a graph between device events."""
    work()
    times = []
    if not device.is_cuda:
        for _ in range(repeats):
            begun = perf_counter()
            work()
            times.append(perf_counter() - begun)
        return spread(times)["median"]
    with wp.ScopedCapture(device) as capture:
        work()
    begin, end = wp.Event(device, enable_timing=True), wp.Event(device, enable_timing=True)
    stream = wp.get_stream(device)
    for _ in range(repeats):
        stream.record_event(begin)
        wp.capture_launch(capture.graph)
        stream.record_event(end)
        times.append(1e-3 * float(wp.get_event_elapsed_time(begin, end)))
    return spread(times)["median"]


def byte_rate(device: wp.Device) -> float:
    """Bytes a second, read and written, of a copy far larger than the caches."""
    count = (1 << 28) // (1 if device.is_cuda else CPU_SHARE // 16)
    source, target = (wp.zeros(count, dtype=float, device=device) for _ in range(2))
    return 8.0 * count / seconds_of(lambda: wp.copy(target, source), device)


def fma_rate(device: wp.Device) -> float:
    """Fused multiply-adds a second, in registers, of float32."""
    count, rounds = (1 << 20) // (1 if device.is_cuda else CPU_SHARE), 2048
    values = wp.full(count, 0.5, dtype=float, device=device)
    work = seconds_of(lambda: launch(fma_kernel, count, [rounds, values], device), device)
    return float(CHAINS * rounds * count) / work


def launch_rate(device: wp.Device) -> float:
    """Launches a second, one after the other, of a kernel that does nothing."""

    def work() -> None:
        for _ in range(LAUNCHES):
            launch(empty_kernel, 1, [], device)

    return LAUNCHES / seconds_of(work, device)


def ray_rates(device_scene: DeviceScene, size: Size, settings: RenderSettings) -> tuple[float, float]:
    """Any-hit rays a second between shading points and VPL clusters, and rays a second through the pixels."""
    device, camera = device_scene.device, device_scene.scene.cameras[0]
    scene = device_scene.view(lambertian=settings.lambertian)
    data = camera_data(camera, device_scene.scene.placement, size[0] / size[1])
    cameras = wp.array([data], dtype=CameraData, device=device)
    pixels = size[0] * size[1]
    distance = wp.zeros(pixels, dtype=float, device=device)
    inputs = [scene, cameras, image_size(size), distance]
    primary = pixels / seconds_of(lambda: launch(primary_kernel, pixels, inputs, device), device)

    gbuffer: GBuffer = allocate(GBuffer, pixels, device)
    trace_primary_rays(scene, cameras, size, gbuffer, chain_samples(device))
    sample_counts = sample_counts_of(settings, device)
    setup = RenderSetup(device_scene, LightSets(device_scene), size, settings, sample_counts, lambda *_: None)
    clusters = setup.light_sets.clusters(light_set_choice(setup), setup.progress)
    chosen = spread_out(gbuffer.face.numpy(), size, sample_counts.sp_clusters)
    if clusters.count == 0 or len(chosen) == 0:
        return 0.0, primary
    sps = np.stack([gbuffer.position.numpy()[chosen], gbuffer.geometric_normal.numpy()[chosen]])
    vpls = np.stack([clusters.disks.numpy()[name] for name in ("position", "normal")])
    pairs = facing_pairs(sps, vpls)
    kernel = any_hit_kernel(connection(scene))
    seen = wp.zeros(len(pairs), dtype=wp.uint8, device=device)
    places = [wp.array(points, dtype=wp.vec3, device=device) for points in (sps, vpls)]
    inputs = [scene, wp.array(pairs, dtype=int, device=device), len(chosen), *places, seen]
    return len(pairs) / seconds_of(lambda: launch(kernel, len(pairs), inputs, device), device), primary


def spread_out(face: Ints, size: Size, wanted: int) -> Ints:
    """Pixels of at most `wanted` shading points, evenly along the Z-order curve. face: (pixel,), NO_HIT for none."""
    order = morton_order(size, wp.get_device("cpu")).numpy()
    order = order[face[order] != NO_HIT]
    return order[np.linspace(0, len(order) - 1, min(wanted, len(order))).astype(int)] if len(order) else order


def facing_pairs(sps: np.ndarray, vpls: np.ndarray) -> Ints:
    """The pairs vpl · (number of SPs) + sp that face each other, in that order. Both: (position or normal, i, 3)."""
    (p, p_normal), (q, q_normal) = sps.astype(np.float64), vpls.astype(np.float64)
    # n·(q − p) > 0 on both sides, each pair by a product of matrices.
    ahead = q @ p_normal.T > np.sum(p * p_normal, axis=1)[None, :]
    back = q_normal @ p.T > np.sum(q * q_normal, axis=1)[:, None]
    return np.flatnonzero(ahead & back).astype(np.int32)
