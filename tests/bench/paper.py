"""The 2022 paper's evaluation: its grids, and what it reports, on an RTX 2060 laptop with scenes of its own."""

from dataclasses import dataclass

# (SP clusters, VPL clusters) of Fig. 10; VPLs of Table 1's conference room.
SETTINGS = ((1000, 750), (8000, 2000), (30_000, 4000))
VPLS = 8000
# Fig. 6 and 7: SPs only; Fig. 8 and 9: VPLs only; Fig. 11: both.
SP_CLUSTERS = (2000, 4000, 8000, 16_000, 30_000)
VPL_CLUSTERS = (500, 1000, 1500, 2000, 2500)
BOTH_SP_CLUSTERS = (1000, 2000, 4000, 8000, 16_000, 30_000)
BOTH_VPL_CLUSTERS = (500, 750, 1000, 2000, 3000, 4000)


@dataclass(frozen=True)
class Point:
    """One reported result. clustering: as in RenderSettings; ms: without tracing and clustering VPLs."""

    figure: str
    clustering: str
    ms: float
    mse: float


# Clustering error: MSE against the same VPLs unclustered.
POINTS = {
    "conference": (
        Point("10a", "both", 34.0, 3.80e-3),
        Point("10b", "both", 109.0, 1.80e-3),
        Point("10c", "both", 328.0, 8.55e-4),
    ),
    "cornell-box": (
        Point("1b", "both", 162.0, 1.10e-3),
        Point("8a", "vpls", 168.0, 1.80e-3),
        Point("8b", "vpls", 439.0, 5.42e-4),
        Point("8c", "vpls", 760.0, 4.20e-4),
    ),
    "living-room": (
        Point("1c", "both", 206.0, 8.13e-4),
        Point("6a", "sps", 319.0, 7.42e-4),
        Point("6b", "sps", 349.0, 4.54e-4),
        Point("6c", "sps", 472.0, 3.00e-4),
    ),
}


def paper_scene(name: str) -> str:
    """What the paper's scene is called here, for the built-in one that resembles it too."""
    return {"conference-room": "conference"}.get(name, name)
