"""Which method renders what settings ask for."""

from typing import Any

from gpu.methods.exact_vpl import ExactVpl
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.method import RenderMethod, RenderSetup
from gpu.methods.path import PathTracing
from gpu.methods.photon_gather import PhotonGather
from gpu.methods.rsm_disks import RsmDisks
from gpu.methods.targeted_vpl import TargetedVpl
from gpu.settings import Clustering, Method, RenderSettings

METHODS: dict[Method, type[RenderMethod[Any]]] = {
    Method.FUZZY_VPL: FuzzyVpl,
    Method.EXACT_VPL: ExactVpl,
    Method.PHOTON_GATHER: PhotonGather,
    Method.PATH: PathTracing,
    Method.RSM_DISKS: RsmDisks,
}


def method_of(settings: RenderSettings) -> type[RenderMethod[Any]]:
    """The class of the method that `settings` ask for."""
    if settings.has_target:
        return TargetedVpl
    if settings.method is Method.FUZZY_VPL and settings.clustering is Clustering.VPLS:
        return ExactVpl  # there are no SP clusters
    return METHODS[settings.method]


def make_method(setup: RenderSetup) -> RenderMethod[Any]:
    """The method that the settings of `setup` ask for."""
    return method_of(setup.settings)(setup)
