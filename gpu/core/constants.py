"""Numbers that kernels of several packages share."""

import warp as wp

TWO_PI = wp.constant(6.283185307179586)
PI = wp.constant(3.141592653589793)
FAR_AWAY = wp.constant(1.0e30)
# Its multiples, in turn, are spread evenly between whole numbers; so are those of GOLDEN_STEP in 2³².
GOLDEN_RATIO = wp.constant(0.6180339887)
GOLDEN_STEP = wp.constant(wp.uint32(0x9E3779B9))
# Of rays that nothing bounds; unit space has the diameter √3.
RAY_LENGTH = wp.constant(1.0e6)
