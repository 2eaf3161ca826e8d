"""How far a render is from a reference: the definitions that every table, test and command of the project uses.

Images are arrays (height, width, 3) of linear Rec. 709 radiance, both of one component (full, direct or indirect).
"""

from dataclasses import dataclass
from typing import Any

import flip_evaluator
import numpy as np
from numpy.typing import ArrayLike, NDArray

from gpu.errors import ImageError

Image = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """The errors of one render. All but `nonfinite` are NaN, which passes no threshold, when a value is not finite.

    nonfinite: values of the render that are NaN or infinite; one is a failure; mse, rel_mse: see the functions;
    flip: mean HDR-FLIP, 0 to 1; energy: mean of the render over the mean of the reference.
    """

    nonfinite: int
    mse: float
    rel_mse: float
    flip: float
    energy: float


def measure(render: ArrayLike, reference: ArrayLike) -> Errors:
    """Return every error of `render` against `reference`; non-finite values are counted first.

    Raises ImageError when the sizes differ, or when the reference has non-finite values or no light.
    """
    nonfinite = nonfinite_count(render)
    _pair(np.zeros_like(render, np.float64) if nonfinite else render, reference)
    if nonfinite:
        return Errors(nonfinite, np.nan, np.nan, np.nan, np.nan)
    return Errors(
        0, mse(render, reference), rel_mse(render, reference), hdr_flip(render, reference), energy(render, reference)
    )


def nonfinite_count(render: ArrayLike) -> int:
    """Return how many values of `render` (pixels times channels) are NaN or infinite."""
    return int(np.count_nonzero(~np.isfinite(np.asarray(render))))


def mse(render: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean of (clip(x/w, 0, 1) − clip(r/w, 0, 1))², w the 99th percentile of the reference r.

    Raises ImageError as `measure` does, and for non-finite renders and references of which 99 % is black.
    """
    x, r = _pair(render, reference)
    white = float(np.percentile(r, 99))
    if not white > 0.0:
        raise ImageError("the reference is black in 99 % of its values; MSE is relative to their 99th percentile")
    return float(np.mean((np.clip(x / white, 0.0, 1.0) - np.clip(r / white, 0.0, 1.0)) ** 2))


def rel_mse(render: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean of (x − r)² / (r² + 0.01·mean(r)²). Raises ImageError as `mse`."""
    x, r = _pair(render, reference)
    return float(np.mean((x - r) ** 2 / (r**2 + 0.01 * np.mean(r) ** 2)))


def hdr_flip(render: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean HDR-FLIP error, 0 (same) to 1, at the evaluator's 67 pixels a degree and its own exposures.

    Raises ImageError as `mse`. Source: P. Andersson et al., "Visualizing Errors in Rendered High Dynamic Range
    Images", Eurographics 2021.
    """
    x, r = _pair(render, reference)
    # The exposures follow the reference, so a common scale changes nothing; but the evaluator ends the whole process
    # when the reference is darker than its floor.
    scale = 1.0 / float(np.max(r))
    evaluate: Any = flip_evaluator.evaluate
    return float(evaluate(_flip_input(r * scale), _flip_input(x * scale), "HDR", applyMagma=False)[1])


def energy(render: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean of the render over the mean of the reference. Raises ImageError as `mse`."""
    x, r = _pair(render, reference)
    return float(np.mean(x) / np.mean(r))


def _pair(render: ArrayLike, reference: ArrayLike) -> tuple[Image, Image]:
    """Return both as float64 once they can be compared."""
    x, r = np.asarray(render, np.float64), np.asarray(reference, np.float64)
    if x.shape != r.shape or x.ndim != 3 or x.shape[2] != 3 or x.size == 0:
        raise ImageError(f"images of {_size(x)} and {_size(r)} cannot be compared; both must be of one size, with RGB")
    if count := nonfinite_count(x):
        raise ImageError(f"the render has {count} non-finite values")
    if count := nonfinite_count(r):
        raise ImageError(f"the reference has {count} non-finite values; it cannot serve as one")
    if not np.mean(r) > 0.0:
        raise ImageError("the reference has no light; errors relative to it are not defined")
    return x, r


def _flip_input(image: Image) -> NDArray[np.float32]:
    """Return what the evaluator takes: finite, non-negative float32."""
    return np.ascontiguousarray(np.clip(image, 0.0, np.finfo(np.float32).max), np.float32)


def _size(image: Image) -> str:
    """Return an array's shape in an image's terms."""
    return "×".join(map(str, (image.shape[1], image.shape[0], *image.shape[2:]))) if image.ndim > 1 else "no pixels"
