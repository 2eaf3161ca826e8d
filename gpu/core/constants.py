"""Numbers that kernels of several packages share."""

import warp as wp

TWO_PI = wp.constant(6.283185307179586)
PI = wp.constant(3.141592653589793)
FAR_AWAY = wp.constant(1.0e30)
# Of rays that nothing bounds; unit space has the diameter √3.
RAY_LENGTH = wp.constant(1.0e6)
