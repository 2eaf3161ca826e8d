"""A G-buffer of a wall, for the tests of what pixels of one surface share."""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gpu.core.device import allocate
from gpu.gbuffer.gbuffer import GBuffer

WIDTH, HEIGHT = 48, 40
CPU = wp.get_device("cpu")
# The left half of the image.
LEFT = np.repeat(np.arange(WIDTH)[None, :] < WIDTH // 2, HEIGHT, axis=0)


def wall(normals: NDArray | None = None, depth: NDArray | None = None, seen: NDArray | None = None) -> GBuffer:
    """A white wall that faces the camera, one unit a pixel; all arguments (HEIGHT, WIDTH, …)."""
    count = WIDTH * HEIGHT
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    z = np.zeros((HEIGHT, WIDTH)) if depth is None else depth
    up = np.zeros((HEIGHT, WIDTH, 3))
    up[..., 2] = 1.0
    up = up if normals is None else normals
    gbuffer: GBuffer = allocate(GBuffer, count, CPU)
    gbuffer.position.assign(np.stack([x, -y, z], axis=2).reshape(count, 3).astype(np.float32))
    gbuffer.normal.assign(up.reshape(count, 3).astype(np.float32))
    gbuffer.geometric_normal.assign(up.reshape(count, 3).astype(np.float32))
    gbuffer.spacing.assign(np.ones(count, np.float32))
    gbuffer.albedo.fill_(1.0)
    gbuffer.throughput.fill_(1.0)
    visible = np.ones((HEIGHT, WIDTH), bool) if seen is None else seen
    gbuffer.face.assign(np.where(visible.ravel(), 0, -1).astype(np.int32))
    return gbuffer


def split_walls() -> dict[str, GBuffer]:
    """Walls whose left half is another surface than the right one."""
    normals = np.where(LEFT[..., None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    return {
        "normals": wall(normals=normals),
        "depth": wall(depth=np.where(LEFT, 0.0, 50.0)),
        "nothing": wall(seen=LEFT),
    }


def grey_values(values: NDArray) -> wp.array:
    """(HEIGHT, WIDTH) numbers as a grey picture, (pixel,)."""
    return wp.array(np.repeat(values.reshape(-1, 1), 3, axis=1).astype(np.float32), dtype=wp.vec3, device=CPU)


def numbers(picture: wp.array) -> NDArray:
    """A grey picture's numbers, (HEIGHT, WIDTH)."""
    return np.asarray(picture.numpy()[:, 0].reshape(HEIGHT, WIDTH))
