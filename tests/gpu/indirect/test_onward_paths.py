from itertools import pairwise

import numpy as np
import pytest
from pictures import lamp_room, picture, relative_error, sconce_room

from gpu.indirect import final_gather
from gpu.indirect.photon_lookup import LOOKUP_PARAMETERS
from gpu.settings import Component, Method

INDIRECT = {"component": Component.INDIRECT, "lambertian": True}


def test_a_path_tells_in_two_parts_what_it_does_in_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Photons answer for one point in four, so most paths go on."""
    monkeypatch.setattr(LOOKUP_PARAMETERS, "reach", 0.2)
    choice = {"method": Method.PHOTON_GATHER, "photons": 1000, "gather_rays": 64, "bounces": 8, **INDIRECT}
    room, parts = lamp_room(), list[tuple[int, int]]()

    def noted(ends: tuple[int, ...]) -> list[tuple[int, int]]:
        parts.extend(pairwise(ends))
        return parts

    monkeypatch.setattr(final_gather, "pairwise", noted)
    in_two = picture(room, **choice)
    assert parts == [(0, 1), (1, 4)]
    monkeypatch.setattr(final_gather, "pairwise", lambda ends: [(ends[0], ends[-1])])
    assert np.array_equal(in_two, picture(room, **choice))
    monkeypatch.setattr(final_gather, "pairwise", lambda ends: [ends[:2]])
    assert picture(room, **choice).mean() < 0.99 * in_two.mean()


def test_where_photons_tell_nothing_rays_go_on_to_the_emitters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Photons answer for next to no point, and there is no light beyond two bounces."""
    monkeypatch.setattr(LOOKUP_PARAMETERS, "reach", 1e-3)
    room = lamp_room()
    choice = {"bounces": 2, **INDIRECT}
    gathered = picture(room, method=Method.PHOTON_GATHER, photons=64, gather_rays=256, **choice)
    paths = picture(room, method=Method.PATH, samples=256, **choice)
    assert gathered.mean() == pytest.approx(paths.mean(), rel=0.02)
    assert relative_error(gathered, paths) < 0.01


def test_paths_find_a_small_bright_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Photons answer behind a lamp that is close to a wall, and for few points elsewhere."""
    monkeypatch.setattr(LOOKUP_PARAMETERS, "reach", 0.3)
    choice = {"method": Method.PHOTON_GATHER, "photons": 16_000, "gather_rays": 64, **INDIRECT}
    far = picture(sconce_room(), **choice)[:22, 22:, 0]
    assert far.max() < 1.65 * np.median(far)
