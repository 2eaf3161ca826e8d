"""What decides how lights share reflective shadow maps; without Warp, for those who only count rays."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ShadowMapParameters:
    """Which lights share a map.

    most_maps: of a scene; where there are more lights, those that follow each other in the table share one.
    least_cosine: between the normals of triangles of one patch; widest: farther apart their centres are not, unit
    space: of a map whose pixels' lights stand far apart or face other ways, neighbours see other surfaces.
    least_side: of maps of lights that have less power than the strongest's, whose pixels have about as much flux each.
    """

    most_maps: int = 16
    least_cosine: float = 0.9
    widest: float = 0.25
    least_side: int = 16


SHADOW_MAP_PARAMETERS = ShadowMapParameters()
