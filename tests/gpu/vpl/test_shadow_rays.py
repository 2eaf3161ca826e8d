import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline
from scenes import results, slats

from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connected_solid
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.vpl.shadow_rays import NO_RAY, arrival, shadow_rays, target_of, trace_shadow_rays
from gpu.vpl.vpl_clusters import VplClusters

RAYS = 5


@wp.kernel
def reference_kernel(first: int, scene: SceneData, gbuffer: GBuffer, points: PointList, vpls: VplClusters,
                     targets: wp.array2d[int], out: wp.array[int]) -> None:  # fmt: skip
    """One thread a ray: whether it arrives."""
    index = first + wp.tid()
    place = index // targets.shape[1]
    vpl = targets[place, index % targets.shape[1]]
    pixel = points.pixels[place]
    there = vpls.members.position[vpl]
    normal = vpls.members.normal[vpl]
    out[index] = int(connected_solid(scene, gbuffer.position[pixel], gbuffer.geometric_normal[pixel], there, normal))


@wp.kernel
def decode_kernel(first: int, vpl: wp.array[int], out: wp.array[wp.vec2]) -> None:
    """One thread a ray: its target, and whether it arrived."""
    index = first + wp.tid()
    out[index] = wp.vec2(float(target_of(vpl[index])), arrival(vpl[index]))


@pytest.mark.parametrize("side_by_side", [True, False])
def test_rays_that_are_blocked_are_marked_and_keep_their_targets(side_by_side: bool) -> None:
    device_scene, camera, size = slats((24, 18))
    fuzzy = Pipeline(device_scene, camera, size, sp_clusters=20)
    view, count = fuzzy.view, fuzzy.sp_count
    targets = np.random.default_rng(0).integers(0, fuzzy.lights.members.count, (view.pixels, RAYS)).astype(np.int32)
    points = view.shading_points.points
    table = wp.array(targets, dtype=int, device=view.device)
    inputs = [view.scene, view.gbuffer, points, fuzzy.lights, table]
    expected = results(reference_kernel, count * RAYS, inputs, wp.int32).reshape(count, RAYS)
    assert 0.2 < expected.mean() < 0.8
    targets[:, 2] = NO_RAY
    rays = shadow_rays(view.pixels, RAYS, view.device, side_by_side=side_by_side, control_variate=False)
    rays.vpl.assign((targets if side_by_side else targets.T).ravel())
    trace_shadow_rays(view.scene, view.gbuffer, points, fuzzy.lights, rays)
    told = results(decode_kernel, view.pixels * RAYS, [rays.vpl], wp.vec2).reshape(-1, 2)
    shape = (view.pixels, RAYS, 2) if side_by_side else (RAYS, view.pixels, 2)
    told = told.reshape(shape) if side_by_side else told.reshape(shape).transpose(1, 0, 2)
    assert np.array_equal(told[:count, :, 0], targets[:count])
    expected[:, 2] = 0
    assert np.array_equal(told[:count, :, 1], expected)
    assert np.array_equal(told[count:, :, 0], targets[count:])  # what is not listed is left as it is
