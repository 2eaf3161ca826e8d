"""What of a scene moves as time goes by: nodes, what hangs on them, materials, lights, and the animations of these.

All is in the file's own coordinates, as readers leave it, so that a pose is made as if the file had been read in it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

STILL = -1
"""The node of what does not move, and the parent of a node that has none."""


class Property(StrEnum):
    """What changes: of a node translation, rotation (x, y, z, w) and scale, the weights of its morph targets, and
    whether it is visible, with what is in it; of a material and of a light what glTF calls so.
    """

    TRANSLATION = "translation"
    ROTATION = "rotation"
    SCALE = "scale"
    WEIGHTS = "weights"
    VISIBLE = "visible"
    BASE_COLOR = "baseColorFactor"
    METALLIC = "metallicFactor"
    ROUGHNESS = "roughnessFactor"
    EMISSIVE = "emissiveFactor"
    EMISSIVE_STRENGTH = "emissiveStrength"
    ALPHA_CUTOFF = "alphaCutoff"
    NORMAL_SCALE = "normalScale"
    TRANSMISSION = "transmissionFactor"
    IOR = "ior"
    DISPERSION = "dispersion"
    ATTENUATION_COLOR = "attenuationColor"
    SPECULAR = "specularFactor"
    SPECULAR_COLOR = "specularColorFactor"
    CLEARCOAT = "clearcoatFactor"
    CLEARCOAT_ROUGHNESS = "clearcoatRoughnessFactor"
    SHEEN_COLOR = "sheenColorFactor"
    SHEEN_ROUGHNESS = "sheenRoughnessFactor"
    IRIDESCENCE = "iridescenceFactor"
    IRIDESCENCE_IOR = "iridescenceIor"
    IRIDESCENCE_LEAST = "iridescenceThicknessMinimum"
    IRIDESCENCE_MOST = "iridescenceThicknessMaximum"
    THROUGH = "diffuseTransmissionFactor"
    THROUGH_COLOR = "diffuseTransmissionColorFactor"
    LIGHT_COLOR = "color"
    INTENSITY = "intensity"
    INNER_CONE = "innerConeAngle"
    OUTER_CONE = "outerConeAngle"


LIGHT_PROPERTIES = frozenset({Property.LIGHT_COLOR, Property.INTENSITY, Property.INNER_CONE, Property.OUTER_CONE})
NODE_PROPERTIES = frozenset(
    {Property.TRANSLATION, Property.ROTATION, Property.SCALE, Property.WEIGHTS, Property.VISIBLE}
)
MATERIAL_PROPERTIES = frozenset(Property) - NODE_PROPERTIES - LIGHT_PROPERTIES
COMPONENTS: Mapping[Property, int | None] = {
    **dict.fromkeys(Property, 1),
    **dict.fromkeys((Property.TRANSLATION, Property.SCALE, Property.EMISSIVE, Property.LIGHT_COLOR), 3),
    **dict.fromkeys((Property.ATTENUATION_COLOR, Property.SPECULAR_COLOR, Property.SHEEN_COLOR), 3),
    Property.THROUGH_COLOR: 3,
    **dict.fromkeys((Property.ROTATION, Property.BASE_COLOR), 4),
    Property.WEIGHTS: None,
}
"""How many numbers a value has; None: as many as there are morph targets."""


class Interpolation(StrEnum):
    """What is between two keys."""

    STEP = "STEP"
    LINEAR = "LINEAR"
    CUBICSPLINE = "CUBICSPLINE"


@dataclass(frozen=True, eq=False)
class Channel:
    """How a property changes: of a node, or of a material or a light of the scene, whose number is `part`.

    times (key,): not decreasing [s]; values (key, 1, component), of a cubic spline (key, 3, component): the tangent
    towards a key, its value, the tangent from it.
    """

    part: int
    changes: Property
    interpolation: Interpolation
    times: NDArray[np.float64]
    values: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Animation:
    """Channels that go together. id: by which it is chosen; seconds: when the last of them ends."""

    id: str
    seconds: float
    channels: tuple[Channel, ...]


@dataclass(frozen=True, eq=False)
class Skin:
    """joints (joint,): nodes; inverse (joint, 4, 4): from the mesh's space to each joint's, when they were bound."""

    joints: NDArray[np.int32]
    inverse: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MorphTarget:
    """What a weight of 1 adds to positions and to normals, (vertex, 3); None: nothing."""

    positions: NDArray[np.float64] | None
    normals: NDArray[np.float64] | None


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh in a space of its own, and what brings it into the file's coordinates.

    positions, normals (vertex, 3), normals None for flat shading; triangles (triangle, 3); instances (instance, 4, 4):
    to its `node`; weights: of its `targets` where no animation says others. With a skin, joints (vertex, slot) are
    numbers of its joints and shares (vertex, slot) what each counts; then node and instances do not matter.
    The scene's vertices from first_vertex on are `vertices` of it as it is placed, instance by instance.
    """

    node: int
    positions: NDArray[np.float64]
    normals: NDArray[np.float64] | None
    triangles: NDArray[np.int64]
    instances: NDArray[np.float64]
    targets: tuple[MorphTarget, ...] = ()
    weights: tuple[float, ...] = ()
    skin: Skin | None = None
    joints: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 0), np.int32))
    shares: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    first_vertex: int = 0
    vertices: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))


@dataclass(frozen=True, eq=False)
class Motion:
    """Nodes, parents before their children, with what hangs on them.

    parents (node,); local (node, 4, 4): to the parent where nothing moves it; rest (node, 10): what that is made of,
    translation, rotation and scale, for nodes that an animation moves; lights, cameras: of the first of a scene's, the
    node of each or STILL; intensity_scale: what a point or spot light of 1 W/sr in the file has in unit space.
    """

    parents: NDArray[np.int32]
    local: NDArray[np.float64]
    rest: NDArray[np.float64]
    animations: tuple[Animation, ...]
    bodies: tuple[Body, ...] = ()
    lights: tuple[int, ...] = ()
    cameras: tuple[int, ...] = ()
    intensity_scale: float = 1.0
