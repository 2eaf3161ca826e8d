"""The stages of `fuzzy-vpl` up to indirect light, one by one, for the tests of those that follow."""

from dataclasses import dataclass, field

import numpy as np
import warp as wp

from gpu.lights import build_light_table
from gpu.resident import ResidentScene
from gpu.scene.types import Camera, Doubles
from gpu.settings import Weighting
from gpu.shade import allocate_indirect, gather, shade
from gpu.sp_clusters import SpClustering
from gpu.view import View
from gpu.visibility import Visibility
from gpu.vpl import trace_vpls
from gpu.vpl_clusters import VplClusters, cluster_vpls


@dataclass
class Pipeline:
    """A view whose SPs and VPLs are clustered, with visibility traced and `view.indirect` shaded."""

    resident: ResidentScene
    camera: Camera
    size: tuple[int, int]
    sp_clusters: int
    fuzziness: int = 6
    vpls: int = 2000
    vpl_clusters: int = 70
    view: View = field(init=False)
    clustering: SpClustering = field(init=False)
    lights: VplClusters = field(init=False)
    visibility: Visibility = field(init=False)

    def __post_init__(self) -> None:
        view = self.view = View(self.resident, self.size, lambertian=True)
        view.look(self.camera)
        view.find_shading_points()
        device = view.device
        self.clustering = SpClustering(view.pixels, self.sp_clusters, self.fuzziness, Weighting.DISTANCE, device)
        self.clustering.run(view.shading_points, view.gbuffer, 0)
        vpls = trace_vpls(self.resident, view.scene, build_light_table(self.resident), self.vpls, 3, 0)
        self.lights = cluster_vpls(self.resident, vpls, self.vpl_clusters, 0)
        self.visibility = Visibility(self.clustering.count, self.lights.count, device)
        self.visibility.trace(view.scene, self.clustering.clusters, self.lights)
        self.shade()

    @property
    def sp_count(self) -> int:
        """How many pixels have an SP."""
        return int(self.view.shading_points.count.numpy()[0])

    @property
    def pixels(self) -> Doubles:
        """The pixels of the SPs, (sp,)."""
        return np.asarray(self.view.shading_points.pixels.numpy()[: self.sp_count])

    def shade(self) -> None:
        """Shade anew with the clusters and visibility as they are now."""
        sps, view = self.view.shading_points, self.view
        view.indirect.radiance.zero_()
        shade(self.fuzziness, view.gbuffer, sps.pixels, sps.count, self.clustering.clusters, self.visibility,
              self.lights, view.indirect)  # fmt: skip

    def radiance(self) -> Doubles:
        """The fuzzy picture, (pixel, 3)."""
        return np.asarray(self.view.indirect.radiance.numpy(), np.float64)

    def exact(self, begin: int = 0, end: int | None = None) -> Doubles:
        """The picture with a ray to each of VPL clusters begin … end − 1 from every SP, (pixel, 3)."""
        out = allocate_indirect(self.view.pixels, wp.get_device("cpu"))
        end = self.lights.count if end is None else end
        gather(self.view.scene, self.view.gbuffer, self.view.shading_points, self.lights, begin, end, out)
        return np.asarray(out.radiance.numpy(), np.float64)


def relative_error(picture: Doubles, reference: Doubles) -> float:
    """Mean of (x − r)² / (r² + 0.01·mean(r)²)."""
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2)))
