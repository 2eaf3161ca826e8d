import pytest
from pictures import lamp_room, picture, relative_error

from gpu.indirect.photon_lookup import LOOKUP_PARAMETERS
from gpu.settings import Component, Method


def test_where_photons_tell_nothing_rays_go_on_to_the_emitters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Photons answer for next to no point, and there is no light beyond two bounces."""
    monkeypatch.setattr(LOOKUP_PARAMETERS, "reach", 1e-3)
    room = lamp_room()
    choice = {"component": Component.INDIRECT, "lambertian": True, "bounces": 2}
    gathered = picture(room, method=Method.PHOTON_GATHER, photons=64, gather_rays=256, **choice)
    paths = picture(room, method=Method.PATH, samples=256, **choice)
    assert gathered.mean() == pytest.approx(paths.mean(), rel=0.02)
    assert relative_error(gathered, paths) < 0.01
