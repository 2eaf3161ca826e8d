"""Polygons light a picture like disks do, but where shape matters."""

import pytest
from pictures import QUALITY, lamp_room, picture, relative_error

from gpu.settings import Component, LightShape, Method

RSM = {**QUALITY, "component": Component.INDIRECT, "method": Method.RSM_DISKS, "near_field": False}


def test_polygons_light_as_disks_do_with_and_without_shadows() -> None:
    room = lamp_room()
    for changes in ({"indirect_shadows": False}, {"correct": False}):
        disks = picture(room, **RSM, **changes).copy()
        polygons = picture(room, **RSM, **changes, light_shape=LightShape.POLYGONS)
        assert polygons.mean() == pytest.approx(disks.mean(), rel=0.06)
        assert 0.0 < relative_error(polygons, disks) < 0.02
