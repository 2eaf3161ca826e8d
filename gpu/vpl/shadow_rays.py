"""Shadow rays from listed shading points to VPLs: drawn by whoever needs them, all traced by one kernel."""

import warp as wp

from gpu.core.device import launch
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.panes import tint_between
from gpu.device_scene.rays import connection
from gpu.device_scene.specialisation import cutouts_of, made_for, ray_registers, specialisation
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.vpl.vpl_clusters import VplClusters

NO_RAY = wp.constant(-1)


@wp.struct
class ShadowRays:
    """Rays of listed points, `per_point` each; `ray_index` tells where each is in the arrays.

    vpl: the VPL that a ray goes to, NO_RAY for none; once traced, `blocked` of it where something stands in between.
    share: the light that it stands for, as the stage that draws it needs it. cluster_visibility: the share of the
    point's SP clusters that see the VPL's cluster; empty where no stage asks. tint: of light that arrives, once traced;
    empty in scenes without part glass.
    """

    vpl: wp.array[int]
    share: wp.array[float]
    cluster_visibility: wp.array[float]
    tint: wp.array[wp.vec3]
    per_point: int
    place_stride: int
    ray_stride: int


def shadow_rays(places: int, per_point: int, device: wp.Device, *, side_by_side: bool, control_variate: bool,
                tinted: bool = False) -> ShadowRays:  # fmt: skip
    """`per_point` rays for each of so many places.

    side_by_side: whether neighbouring threads trace the rays of one point, else rays of one number of neighbouring
    points; control_variate: whether they have a `cluster_visibility`; tinted: whether in a scene with part glass.
    """
    rays = ShadowRays()
    rays.vpl = wp.full(places * per_point, int(NO_RAY), dtype=int, device=device)
    rays.share = wp.zeros(places * per_point, dtype=float, device=device)
    if control_variate:
        rays.cluster_visibility = wp.zeros(places * per_point, dtype=float, device=device)
    if tinted:
        rays.tint = wp.zeros(places * per_point, dtype=wp.vec3, device=device)
    rays.per_point = per_point
    rays.place_stride, rays.ray_stride = (per_point, 1) if side_by_side else (1, places)
    return rays


@wp.func
def ray_index(rays: ShadowRays, place: int, ray: int) -> int:
    """Where ray number `ray` of the point at a place is in the arrays of `rays`."""
    return place * rays.place_stride + ray * rays.ray_stride


@wp.func
def thread_ray(rays: ShadowRays, thread: int, count: int) -> wp.vec2i:
    """Place and number of the ray that a thread has, where `count` points are listed; their number is `per_point` each.

    Neighbouring threads have neighbours in the arrays.
    """
    if rays.ray_stride == 1:
        return wp.vec2i(thread // rays.per_point, thread % rays.per_point)
    return wp.vec2i(thread % count, thread // count)


@wp.func
def blocked(vpl: int) -> int:
    """What stands in `vpl` for a VPL that the ray does not reach; of that, the VPL."""
    return -2 - vpl


@wp.func
def target_of(vpl: int) -> int:
    """The VPL that a traced ray went to, whether it arrived or not; NO_RAY for none."""
    if vpl < NO_RAY:
        return blocked(vpl)
    return vpl


@wp.func
def arrival(vpl: int) -> float:
    """1 where a traced ray arrived, else 0."""
    return wp.where(vpl >= 0, 1.0, 0.0)


@wp.func
def colouring(rays: ShadowRays, index: int) -> wp.vec3:
    """How much more than white light a traced ray brings of each colour."""
    if rays.tint.shape[0] == 0 or rays.vpl[index] < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    return rays.tint[index] - wp.vec3(1.0, 1.0, 1.0)


@made_for("cutouts", "part_glass")
def shadow_ray_kernel(features: SceneFeatures, connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, gpu.device_scene.rays.connected or a variant of it."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", cuda_max_registers=ray_registers(features))
    def shadow_ray_kernel(
        first: int, scene: SceneData, gbuffer: GBuffer, points: PointList, vpls: VplClusters, rays: ShadowRays
    ) -> None:
        """One thread a ray: marks its VPL as blocked unless the ray arrives, and tells its tint if it does."""
        if wp.static(features.part_glass or not features.cutouts):
            scene = specialise(scene)
        thread = first + wp.tid()
        if thread >= rays.per_point * points.count[0]:
            return
        at = thread_ray(rays, thread, points.count[0])
        index = ray_index(rays, at[0], at[1])
        vpl = rays.vpl[index]
        if vpl < 0:
            return
        pixel = points.pixels[at[0]]
        position = vpls.members.position[vpl]
        normal = vpls.members.normal[vpl]
        if not connect(scene, gbuffer.position[pixel], gbuffer.geometric_normal[pixel], position, normal):
            rays.vpl[index] = blocked(vpl)
            return
        if wp.static(features.part_glass):
            tint = tint_between(scene, gbuffer.position[pixel], gbuffer.geometric_normal[pixel], position, normal)
            if rays.tint.shape[0] > 0:
                rays.tint[index] = tint

    return shadow_ray_kernel


def trace_shadow_rays(scene: SceneData, gbuffer: GBuffer, points: PointList, vpls: VplClusters,
                      rays: ShadowRays) -> None:  # fmt: skip
    """Find which of the `rays` of `points` to members of `vpls` arrive."""
    inputs = [scene, gbuffer, points, vpls, rays]
    kernel = shadow_ray_kernel(cutouts_of(scene), connection(scene))
    launch(kernel, rays.per_point * len(points.pixels), inputs, rays.vpl.device)
