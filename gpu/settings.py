"""What a user can choose of a render, with its limits: one model for the command line, REST and the page's panel."""

from dataclasses import asdict
from enum import StrEnum
from math import isfinite

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError


class Method(StrEnum):
    """How light is computed."""

    FUZZY_VPL = "fuzzy-vpl"
    EXACT_VPL = "exact-vpl"
    PHOTON_GATHER = "photon-gather"
    PATH = "path"
    RSM_DISKS = "rsm-disks"

    @property
    def refines_by_samples(self) -> bool:
        """Whether a frame of many samples can be split into several of fewer, for the same time and quality."""
        return self is Method.PATH

    @property
    def corrects_clusters(self) -> bool:
        """Whether rays of single pixels correct what SP clusters tell, so that a few pixels need no cluster more."""
        return self is Method.FUZZY_VPL


class Component(StrEnum):
    """Which part of the light is in the picture."""

    FULL = "full"
    DIRECT = "direct"
    INDIRECT = "indirect"


class Clustering(StrEnum):
    """What is clustered: the ablation of the 2022 paper, section 4."""

    BOTH = "both"
    SPS = "sps"
    VPLS = "vpls"


class LightShape(StrEnum):
    """What stands for clusters of reflective shadow maps: 2012 paper, section 5."""

    DISKS = "disks"
    POLYGONS = "polygons"


class Weighting(StrEnum):
    """How the F clusters of a shading point are averaged: 2022 paper, Eq. 8 (average) or Eq. 9 and 10 (distance)."""

    DISTANCE = "distance"
    AVERAGE = "average"


class Quality(StrEnum):
    """How many there are of what a user has not counted: gpu.sample_counts says how many times as many as usual."""

    DRAFT = "draft"
    BALANCED = "balanced"
    BEST = "best"


class Skips(BaseModel):
    """Work that is not done since a scene or a frame does not need it; each can be switched off, to see what it gains.

    A frame's statistics count under the same names (gpu.film.frame.FrameStats).
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    unchanged_camera: bool = Field(True, description="no frame of the view that the last one was of, but its picture")
    unchanged_lights: bool = Field(True, description="no new VPLs where those of the same light and choices are kept")
    kept_clusters: bool = Field(True, description="no new SP clusters and rays where a like view just had them")
    temporal_reuse: bool = Field(
        True, description="less sharing of light and fewer rays where a walk's earlier frames found it"
    )
    interpolated: bool = Field(True, description="no shading of pixels whose neighbours tell their indirect light")
    facing_away: bool = Field(True, description="no ray between clusters that face away from or lie behind each other")
    shared_weak_rays: bool = Field(True, description="one ray for neighbouring VPL clusters that send little light")
    far_field_sums: bool = Field(
        True, description="no shading of pixels by far VPL clusters one by one, but by their sums"
    )
    absent_alpha: bool = Field(True, description="no code for alpha masks in kernels where none lets light through")
    absent_textures: bool = Field(True, description="no code for textures in kernels where there are none")
    absent_gloss: bool = Field(True, description="no code for rays of specular lobes where none is narrow")


EVERY_SKIP = Skips()
_BOUNDS = {"gt": "above", "ge": "of at least", "lt": "below", "le": "at most"}


class RenderSettings(BaseModel):
    """Method and quality of a render. A count that is None is chosen for the device (fewer on a CPU)."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    method: Method = Field(
        Method.FUZZY_VPL,
        description="how light is computed; rsm-disks is for lights that move, and shows one indirect bounce, "
        "photon-gather makes all bounces anew in each frame",
    )
    quality: Quality = Field(
        Quality.BALANCED,
        description="a quarter, or twice, of all counts that are left open, but for light samples; of frames an "
        "eighth, or four times",
    )
    component: Component = Field(Component.FULL, description="which part of the light is in the picture")
    sp_clusters: int | None = Field(None, ge=1, le=262_144, description="clusters of shading points (SPs)")
    vpls: int | None = Field(None, ge=1, le=4_194_304, description="virtual point lights (VPLs), about")
    vpl_clusters: int | None = Field(None, ge=1, le=65_536, description="clusters of VPLs")
    shadow_map: int | None = Field(
        None,
        ge=64,
        le=512,
        description="rsm-disks: pixels along each side of the strongest light's reflective shadow map, 64 · 2ⁿ",
    )
    indirect_shadows: bool = Field(
        True, description="rsm-disks: what stands in the way hides indirect light, which is left out in its paper"
    )
    photons: int | None = Field(None, ge=1, le=4_194_304, description="photon-gather: photons that are stored, about")
    cut_nodes: int = Field(
        0,
        ge=0,
        le=262_144,
        description="photon-gather: groups of photons that gather rays read, at most; 0: all",
    )
    gather_rays: int | None = Field(
        None, ge=1, le=4096, description="photon-gather: rays that gather light at each SP cluster"
    )
    caustic_photons: int | None = Field(
        None,
        ge=1,
        le=4_194_304,
        description="paths of light by mirrors, glass and metal, whose ends are caustics; all but path",
    )
    light_shape: LightShape = Field(
        LightShape.DISKS, description="rsm-disks: what clusters light as; polygons are slower, and without corrections"
    )
    clustering: Clustering = Field(Clustering.BOTH, description="what is clustered")
    target_ms: float | None = Field(
        None, gt=0.0, le=10_000.0, description="time until a frame is ready [ms] that counts of clusters are chosen for"
    )
    target_error: float | None = Field(
        None,
        ge=1e-6,
        le=1.0,
        description="or MSE of indirect light, against exact-vpl with the same VPLs, that they are chosen for",
    )
    fuzziness: int = Field(6, ge=1, le=8, description="clusters that each shading point belongs to (F)")
    weighting: Weighting = Field(Weighting.DISTANCE, description="weights of the F clusters")
    bounces: int | None = Field(
        None,
        ge=1,
        le=16,
        description="indirect bounces; left empty, 4, or 6 where surfaces shine; rsm-disks shows the first",
    )
    samples: int | None = Field(None, ge=1, le=65_536, description="light samples a pixel; for path: paths a pixel")
    frames: int | None = Field(
        None,
        ge=1,
        le=4096,
        description="frames averaged when still, each with its own rays and pixel positions; 1 for stills by command "
        "or REST, unless told",
    )
    correct: bool = Field(True, description="check what clusters believe of visibility by rays of the pixels shaded")
    near_field: bool = Field(
        True, description="give back light that VPLs lose near corners, by a ray of each pixel shaded"
    )
    smooth: bool = Field(True, description="share soft light between neighbouring pixels of one surface")
    antialias: bool = Field(
        True, description="smooth edges in a walk by the frames before: fuzzy-vpl and rsm-disks, with temporal_reuse"
    )
    seed: int = Field(0, ge=0, le=2**31 - 1, description="of all random numbers: same seed, same picture")
    lambertian: bool = Field(False, description="opaque Lambertian surfaces with geometric normals, as the references")
    exposure: float | None = Field(
        None, gt=0.0, le=1e12, description="factor from radiance to display; left empty, chosen for each picture"
    )
    skip: Skips = Field(EVERY_SKIP, description="leaving out work that a scene or a frame does not need")

    @field_validator("exposure", "target_ms", "target_error", mode="before")
    @classmethod
    def _is_finite(cls, value: object, info: ValidationInfo) -> object:
        """NaN breaks each bound, of which one alone would be told."""
        if info.field_name is not None and isinstance(value, float) and not isfinite(value):
            said = [asdict(bound) for bound in cls.model_fields[info.field_name].metadata]
            words = [f"{word} {bound[name]:g}" for bound in said for name, word in _BOUNDS.items() if name in bound]
            raise PydanticCustomError("finite", "must be a finite number {range}", {"range": " and ".join(words)})
        return value

    @field_validator("shadow_map")
    @classmethod
    def _is_halved_evenly(cls, value: int | None) -> int | None:
        """Warping by importance halves a map's sides again and again."""
        if value is not None and value & (value - 1):
            raise PydanticCustomError("power_of_two", "must be 64, 128, 256 or 512")
        return value

    @field_validator("clustering")
    @classmethod
    def _is_of_the_method(cls, value: Clustering, info: ValidationInfo) -> Clustering:
        """A final gather and the clusters of shadow maps know no other."""
        method = info.data.get("method")
        if value is not Clustering.BOTH and method in (Method.PHOTON_GATHER, Method.RSM_DISKS):
            raise PydanticCustomError("clustering", "must be both for {method}", {"method": method.value})
        return value

    @field_validator("target_ms", "target_error")
    @classmethod
    def _is_met_by_clusters(cls, value: float | None, info: ValidationInfo) -> float | None:
        """A target needs indirect light of clusters whose counts are free; of two targets, one is enough."""
        needed = {
            "method": Method.FUZZY_VPL,
            "clustering": Clustering.BOTH,
            "sp_clusters": None,
            "vpl_clusters": None,
            "target_ms": None,
        }
        wrong = [f"{name} {of or 'left out'}" for name, of in needed.items() if info.data.get(name, of) != of]
        if info.data.get("component") is Component.DIRECT:
            wrong.append("component full or indirect")
        if value is not None and wrong:
            raise PydanticCustomError("target", "needs {wrong}", {"wrong": " and ".join(wrong)})
        return value

    @property
    def has_target(self) -> bool:
        """Whether counts of clusters follow a target."""
        return self.target_ms is not None or self.target_error is not None
