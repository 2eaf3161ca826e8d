"""Indirect light with a shadow ray to each VPL. Eq. 5 of the 2022 paper."""

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.kahan import Sum, kahan_add
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.panes import tint_between
from gpu.device_scene.rays import connection
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.irradiance import Indirect
from gpu.indirect.received_lobes import received_by_lobe
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import unoccluded_irradiance
from gpu.vpl.vpl_clusters import VplClusters
from gpu.vpl.vpl_lobes import VplLobes, by_lobe, no_lobes


@made_for("part_glass")
def exact_gather_kernel(features: SceneFeatures, connect: wp.Function) -> wp.Kernel:
    """The kernel for scenes of these `features` that traces with `connect`, gpu.device_scene.rays.connected or a
    variant of it.
    """
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def exact_gather_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        vpls: VplClusters,
        lobes: VplLobes,
        begin: int,
        end: int,
        out: Indirect,
    ) -> None:
        """One thread an SP: adds the light of VPL clusters begin … end − 1, with a shadow ray to each."""
        if wp.static(features.part_glass):
            scene = specialise(scene)
        sp = first + wp.tid()
        if sp >= points.count[0]:
            return
        pixel = points.pixels[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        geometric_normal = gbuffer.geometric_normal[pixel]
        irradiance = Sum()
        for vpl in range(begin, end):
            light = unoccluded_irradiance(position, normal, vpls, vpl)
            disk = disk_at(vpls.disks, vpl)
            if brightness(light) > 0.0 and connect(scene, position, geometric_normal, disk.position, disk.normal):
                if wp.static(features.part_glass):
                    tint = tint_between(scene, position, geometric_normal, disk.position, disk.normal)
                    light = wp.cw_mul(light, tint)
                if lobes.count > 0:
                    to_light = wp.normalize(disk.position - position)
                    light = wp.cw_mul(light, by_lobe(lobes, vpls.members, vpl, -to_light))
                    light = wp.cw_mul(light, received_by_lobe(gbuffer, pixel, to_light))
                irradiance = kahan_add(irradiance, light)
        before = Sum()
        if begin > 0:
            before.total = out.irradiance[pixel]
            before.compensation = out.lost[pixel]
        after = kahan_add(before, irradiance.total)
        out.irradiance[pixel] = after.total
        out.lost[pixel] = after.compensation

    return exact_gather_kernel


def gather(scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, begin: int, end: int,
           out: Indirect, lobes: "VplLobes | None" = None) -> None:  # fmt: skip
    """Add the light of VPL clusters begin … end − 1 to `out`, every pair's visibility traced; the first run sets it.

    lobes: of single VPLs, where each of `vpls` is one.
    """
    inputs = [scene, gbuffer, sps.points, vpls, lobes or no_lobes(), begin, end, out]
    launch(
        exact_gather_kernel(part_glass_of(scene), connection(scene)),
        sps.capacity,
        inputs,
        sps.device,
        weight=end - begin,
    )
