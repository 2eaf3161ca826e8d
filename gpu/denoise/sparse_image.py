"""An image of which some pixels have shading points, as kernels take it (gpu.gbuffer.sparse_shading)."""

import warp as wp

from gpu.core.image_size import ImageSize, image_size
from gpu.gbuffer.shading_points import ShadingPoints


@wp.struct
class SparseImage:
    """image: its size; listed (pixel,): 1 for pixels with SPs, else 0; stride: of the anchors [pixels]."""

    image: ImageSize
    listed: wp.array[int]
    stride: int


def sparse_image(size: tuple[int, int], sps: ShadingPoints) -> SparseImage:
    """The struct of an image of `size` (width, height) with these SPs."""
    sparse = SparseImage()
    sparse.image, sparse.listed, sparse.stride = image_size(size), sps.listed, sps.stride
    return sparse
