from typing import Any

import pytest

from gpu.methods.rays import CAUSTIC_RAYS, PIXEL_RAYS, SITE_RAYS, VERTEX_RAYS, frame_rays
from gpu.sample_counts import SampleCounts
from gpu.settings import RenderSettings

COUNTS = SampleCounts(
    sp_clusters=100,
    vpls=1000,
    vpl_clusters=50,
    photons=500,
    gather_rays=20,
    caustic_photons=30,
    samples=2,
    frames=1,
    shadow_map=64,
)
CAUSTICS = 30 * (CAUSTIC_RAYS + SITE_RAYS)
OWN = 10_000 * (PIXEL_RAYS + 2) + CAUSTICS + 1000 * VERTEX_RAYS


@pytest.mark.parametrize(
    ("settings", "rays"),
    [
        ({"method": "path", "bounces": 3}, 10_000 * 2 * VERTEX_RAYS * 4),
        ({"method": "exact-vpl"}, OWN + 10_000 * 1000),
        ({"method": "photon-gather"}, 10_000 * (PIXEL_RAYS + 2) + CAUSTICS + 500 + 500 * SITE_RAYS + 100 * 20),
        (
            {"method": "photon-gather", "cut_nodes": 60},
            10_000 * (PIXEL_RAYS + 2) + CAUSTICS + 500 + 60 * SITE_RAYS + 100 * 20,
        ),
        ({"clustering": "vpls"}, OWN + 10_000 * 50),
        ({"clustering": "sps"}, OWN + 100 * 1000),
        ({"method": "rsm-disks"}, 10_000 * (PIXEL_RAYS + 2) + CAUSTICS + 16 * 64 * 64 + 100 * 50),
        ({}, OWN + 100 * 50),
    ],
)
def test_rays_follow_from_counts(settings: dict[str, Any], rays: int) -> None:
    assert frame_rays(RenderSettings(**settings), COUNTS, 10_000) == rays


def test_there_are_no_more_clusters_than_pixels() -> None:
    assert frame_rays(RenderSettings(), COUNTS, 1) == PIXEL_RAYS + 2 + CAUSTICS + 1000 * VERTEX_RAYS + 50
