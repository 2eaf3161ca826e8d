"""The coordinates of a file: which axis is up, how long a unit is, and where the scene's are counted from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gpu.scene.import_options import Axis


@dataclass(frozen=True)
class FileFrame:
    """How coordinates of a file become those of the world, which are metres with +Y up.

    world = turn(metres_per_unit · (file − origin)), where the turn takes +Z to +Y, and +Y to −Z, if `up` is "z".
    """

    up: Axis = "y"
    metres_per_unit: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def to_world(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (…, 3) of the file in the world."""
        return self.turned((points - np.array(self.origin)) * self.metres_per_unit)

    def to_file(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (…, 3) of the world in the file's coordinates."""
        return self.turned_back(points) / self.metres_per_unit + np.array(self.origin)

    def turned(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Directions (…, 3) of the file in the world."""
        return vectors if self.up == "y" else np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)

    def turned_back(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Directions (…, 3) of the world in the file's axes."""
        return vectors if self.up == "y" else np.stack([vectors[..., 0], -vectors[..., 2], vectors[..., 1]], axis=-1)
