"""The stages of `fuzzy-vpl` up to indirect light, one by one, for the tests of those that follow."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import warp as wp
from frame_view import FrameView
from lit_surfaces import cluster_vpls
from scenes import column, results, traced_vpls

from gpu.core.device import allocate, launch
from gpu.core.kahan import Sum, kahan_add
from gpu.correction.visibility_correction import Correction, RayPasses
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connected_solid
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ListedPoints
from gpu.indirect.clustered_light import ClusteredLight, clustered_light, guides_of
from gpu.indirect.exact_gather import gather
from gpu.indirect.far_field import FarSums, visibility_weight
from gpu.indirect.fuzzy_shading import shade
from gpu.indirect.irradiance import allocate_indirect
from gpu.indirect.visibility import Visibility
from gpu.scene.types import Camera, Doubles, Ints
from gpu.sp.sp_clustering import SpClustering
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_area, disk_transfer, unoccluded_irradiance
from gpu.vpl.vpl_clusters import VplClusters


@wp.kernel
def light_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], vpls: VplClusters,
                 out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pair: what a VPL cluster sends an SP if nothing hides it."""
    pair = first + wp.tid()
    pixel = pixels[pair // vpls.count]
    out[pair] = unoccluded_irradiance(gbuffer.position[pixel], gbuffer.normal[pixel], vpls, pair % vpls.count)


@wp.kernel
def seen_kernel(first: int, scene: SceneData, gbuffer: GBuffer, pixels: wp.array[int], vpls: VplClusters,
                out: wp.array[int]) -> None:  # fmt: skip
    """One thread a pair: whether an SP sees a VPL cluster's representative."""
    pair = first + wp.tid()
    pixel = pixels[pair // vpls.count]
    vpl = pair % vpls.count
    disk = disk_at(vpls.disks, vpl)
    out[pair] = int(
        connected_solid(scene, gbuffer.position[pixel], gbuffer.geometric_normal[pixel], disk.position, disk.normal)
    )


@wp.kernel
def member_kernel(first: int, scene: SceneData, gbuffer: GBuffer, pixels: wp.array[int], vpls: VplClusters,
                  out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: its light of all members, each a disk as large as its cluster's are at that distance."""
    pixel = pixels[first + wp.tid()]
    position = gbuffer.position[pixel]
    total = Sum()
    for vpl in range(vpls.count):
        for member in range(vpls.starts[vpl], vpls.starts[vpl + 1]):
            way = vpls.members.position[member] - position
            normal = vpls.members.normal[member]
            share = disk_transfer(way, gbuffer.normal[pixel], normal, disk_area(position, vpls, member))
            there = vpls.members.position[member]
            if share > 0.0 and connected_solid(scene, position, gbuffer.geometric_normal[pixel], there, normal):
                total = kahan_add(total, vpls.members.flux[member] * share)
    out[pixel] = total.total


@wp.kernel
def doubt_kernel(first: int, shares: wp.array[float], out: wp.array[float]) -> None:
    """One thread a share of an SP's clusters that sees a VPL cluster: the visibility_weight about it."""
    index = first + wp.tid()
    out[index] = visibility_weight(shares[index])


@cache
def weight_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that tells the weights that SPs of F = `fuzziness` clusters each give them."""
    guides = guides_of(fuzziness)

    @wp.kernel(module="unique")
    def kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], known: ClusteredLight, count: int,
               out: wp.array[float]) -> None:  # fmt: skip
        """One thread an SP."""
        sp = first + wp.tid()
        guided = guides(known, sp, gbuffer.position[pixels[sp]], gbuffer.normal[pixels[sp]])
        for f in range(wp.static(fuzziness)):
            out[f * count + sp] = guided.weight[f]

    return kernel


@dataclass
class Pipeline:
    """A view whose SPs and VPLs are clustered, with visibility traced and `view.indirect` shaded.

    far_field_sums: whether far VPL clusters are summed at representatives.
    """

    device_scene: DeviceScene
    camera: Camera
    size: tuple[int, int]
    sp_clusters: int
    fuzziness: int = 6
    vpls: int = 2000
    vpl_clusters: int = 70
    far_field_sums: bool = False
    view: FrameView = field(init=False)
    clustering: SpClustering = field(init=False)
    lights: VplClusters = field(init=False)
    visibility: Visibility = field(init=False)
    far: FarSums = field(init=False)

    def __post_init__(self) -> None:
        view = self.view = FrameView(self.device_scene, self.size, lambertian=True)
        view.set_camera(self.camera)
        view.find_shading_points()
        device = view.device
        self.clustering = SpClustering(view.shading_points, self.sp_clusters, self.fuzziness, by_distance=True)
        self.clustering.run(view.gbuffer, 0)
        vpls = traced_vpls(self.device_scene, view.scene, self.vpls, 3)
        self.lights = cluster_vpls(self.device_scene, vpls, self.vpl_clusters, 0)
        self.visibility = Visibility(self.clustering.count, self.lights.count, device)
        self.visibility.trace(view.scene, self.clustering.clusters, self.lights)
        self.far = FarSums(self.clustering.count, self.lights.count, device, enabled=self.far_field_sums)
        self.shade()

    @property
    def sp_count(self) -> int:
        """How many pixels have an SP."""
        return int(self.view.shading_points.count.numpy()[0])

    @property
    def pixels(self) -> Ints:
        """The pixels of the SPs, (sp,)."""
        return np.asarray(self.view.shading_points.pixels.numpy()[: self.sp_count])

    @property
    def known(self) -> ClusteredLight:
        """What the clusters know, as kernels take it."""
        return clustered_light(self.clustering.clusters, self.visibility.words, self.lights, self.far.data)

    def shade(self, seed: int = 0) -> None:
        """Shade anew with the clusters and visibility as they are now."""
        view, clusters = self.view, self.clustering.clusters
        view.seed.fill_(seed)
        self.far.run(clusters, self.visibility.words, self.lights, few=False)
        shade(self.fuzziness, view.gbuffer, view.shading_points, self.known, view.seed, view.indirect)

    def correct(self, correction: Correction, seed: int, numbers: range = range(1),
                points: ListedPoints | None = None, settled: wp.array | None = None, *,
                as_wanted: bool = False) -> None:  # fmt: skip
        """Check what is shaded, at all SPs or at `points`, by passes of these `numbers`.

        settled, as_wanted: as for `RayPasses`.
        """
        view = self.view
        if settled is None:
            settled = wp.zeros(view.pixels, dtype=int, device=view.device)
        view.seed.fill_(seed)
        correction.trace(view.scene, view.gbuffer, points or view.shading_points, self.known, view.indirect,
                         RayPasses(view.seed, settled, numbers, as_wanted=as_wanted))  # fmt: skip

    def believe(self, seen: Doubles) -> None:
        """Have the clusters believe `seen` (sp cluster, VPL cluster), 0 or 1, and shade anew."""
        padded = np.zeros((len(seen), 32 * self.visibility.words.shape[1]), np.uint8)
        padded[:, : self.lights.count] = seen
        self.visibility.words.assign(np.packbits(padded, axis=1, bitorder="little").view("<u4"))
        self.shade()

    def beliefs(self) -> Doubles:
        """What the clusters believe, (sp cluster, VPL cluster), 0 or 1."""
        words = self.visibility.words.numpy().astype("<u4").view(np.uint8)
        return np.unpackbits(words, axis=1, bitorder="little")[:, : self.lights.count].astype(np.float64)

    def shares(self) -> Doubles:
        """The share of each SP's clusters, by weight, that believes to see each VPL cluster, (sp, VPL cluster)."""
        clusters, count, fuzziness = self.clustering.clusters, self.sp_count, self.fuzziness
        inputs = [self.view.gbuffer, self.view.shading_points.pixels, self.known, count]
        weights = results(weight_kernel(fuzziness), count, inputs, float, fuzziness).reshape(fuzziness, count)
        return np.einsum("fs,fsv->sv", weights, self.beliefs()[clusters.cluster.numpy()[:, :count]])

    def unhidden(self) -> Doubles:
        """What each VPL cluster sends each SP if nothing hides it, (sp, VPL cluster, 3)."""
        count, lights = self.sp_count, self.lights
        inputs = [self.view.gbuffer, self.view.shading_points.pixels, lights]
        return results(light_kernel, count * lights.count, inputs, wp.vec3).reshape(count, lights.count, 3)

    def doubts(self) -> Doubles:
        """The visibility_weight about what the clusters believe, (sp, VPL cluster)."""
        shares = self.shares()
        return results(doubt_kernel, shares.size, [column(shares.ravel(), float)], float).reshape(shares.shape)

    def seen(self) -> Doubles:
        """Whether each SP sees each VPL cluster's representative, (sp, VPL cluster), 0 or 1."""
        count, lights, view = self.sp_count, self.lights, self.view
        inputs = [view.scene, view.gbuffer, view.shading_points.pixels, lights]
        return results(seen_kernel, count * lights.count, inputs, wp.int32).reshape(count, lights.count)

    def know_the_truth(self) -> None:
        """Make each SP a cluster of its own that sees what the SP sees, and shade anew; wants a fuzziness of 1."""
        capacity, count, device = self.view.pixels, self.sp_count, self.view.device
        clusters: SpClusters = allocate(SpClusters, count, device)
        for name in ("position", "geometric_normal", "normal"):
            getattr(clusters, name).assign(getattr(self.view.gbuffer, name).numpy()[self.pixels])
        clusters.spacing.fill_(1.0)
        clusters.used.fill_(1)
        clusters.fresh = wp.full(1, count, dtype=int, device=device)
        clusters.order.assign(np.arange(count, dtype=np.int32))
        clusters.cluster = wp.array(np.arange(capacity)[None] % count, dtype=int, device=device)
        clusters.weight = wp.ones((1, capacity), dtype=float, device=device)
        self.clustering.clusters = clusters
        self.far = FarSums(count, self.lights.count, device, enabled=self.far_field_sums)
        self.visibility.words = wp.zeros((count, self.visibility.words.shape[1]), dtype=wp.uint32, device=device)
        self.believe(self.seen())

    def irradiance(self) -> Doubles:
        """Fuzzy irradiance, (pixel, 3)."""
        return np.asarray(self.view.indirect.irradiance.numpy(), np.float64)

    def gathered(self, vpls: VplClusters, begin: int = 0, end: int | None = None) -> Doubles:
        """Irradiance with a ray to each of `vpls` begin … end − 1 from every SP, (pixel, 3)."""
        out = allocate_indirect(self.view.pixels, self.view.device)
        end = vpls.count if end is None else end
        gather(self.view.scene, self.view.gbuffer, self.view.shading_points, vpls, begin, end, out)
        return np.asarray(out.irradiance.numpy(), np.float64)

    def exact(self) -> Doubles:
        """Irradiance with a ray to the representative of each VPL cluster from every SP, (pixel, 3)."""
        return self.gathered(self.lights)

    def of_members(self) -> Doubles:
        """Irradiance with a ray to each member of the VPL clusters from every SP, (pixel, 3)."""
        out = wp.zeros(self.view.pixels, dtype=wp.vec3, device=self.view.device)
        sps = self.view.shading_points
        inputs = [self.view.scene, self.view.gbuffer, sps.pixels, self.lights, out]
        launch(member_kernel, self.sp_count, inputs, self.view.device)
        return np.asarray(out.numpy(), np.float64)


def relative_error(picture: Doubles, reference: Doubles) -> float:
    """Mean of (x − r)² / (r² + 0.01·mean(r)²)."""
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2)))
