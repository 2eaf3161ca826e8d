"""What measurements say once they are made: spreads, slopes, equal error, flicker, and errors told apart. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Images = Sequence[NDArray[Any]] | NDArray[Any]


def spread(values: ArrayLike) -> dict[str, float]:
    """Median, 5th and 95th percentile."""
    p5, median, p95 = np.percentile(np.asarray(values), (5, 50, 95))
    return {"median": float(median), "p5": float(p5), "p95": float(p95)}


def error_beyond_noise(render: NDArray[Any], reference: NDArray[Any], other: NDArray[Any]) -> float:
    """relMSE of a render against the truth, of which `reference` and `other` are two pictures with noise of their own.

    The product of the differences from both is right in the mean where the square of one would count its noise, too.
    Weights are the reference's, as in gpu.film.metrics.
    """
    x, r, o = (np.asarray(image, np.float64) for image in (render, reference, other))
    return float(np.mean((x - r) * (x - o) / (r**2 + 0.01 * np.mean(r) ** 2)))


def slope(xs: ArrayLike, ys: ArrayLike) -> float:
    """The power p of y ∝ xᵖ: the least-squares line's slope in logarithms. NaN with fewer than two different x."""
    x, y = np.log(np.asarray(xs, np.float64)), np.log(np.asarray(ys, np.float64))
    if len(np.unique(x)) < 2:
        return float("nan")
    return float(np.polyfit(x, y, 1)[0])


def time_to_equal_error(points: Sequence[tuple[float, float]], wanted: float) -> float | None:
    """When a method, measured at (time, error) points, reaches the error `wanted`; None beyond what was measured.

    Interpolated measurements error is a power of time, as it is for sampling.
    """
    time, error = np.log(np.array(sorted(points), np.float64).T)
    goal = np.log(wanted)
    for now in range(1, len(time)):
        before, after = error[now - 1], error[now]
        if after <= goal <= before:
            share = (before - goal) / (before - after) if before > after else 0.0
            return float(np.exp(time[now - 1] + share * (time[now] - time[now - 1])))
    return None


def front(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Those of the (time, error) points that no other is both faster and better than, by time."""
    best: list[tuple[float, float]] = []
    for time, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((time, error))
    return best


@dataclass(frozen=True)
class Flicker:
    """How a walk's frames change, as a share of the reference's mean radiance.

    change, reference_change: mean absolute difference of consecutive frames, of the render and of the reference;
    flicker: what the render's is beyond the reference's; error_change: mean absolute change of render − reference,
    which a render that changes as much as it should, but elsewhere, does not escape.
    """

    change: float
    reference_change: float
    flicker: float
    error_change: float


def flicker(renders: Images, references: Images) -> Flicker:
    """Compare consecutive frames of a walk with those of its reference; both (frame, height, width, 3)."""
    x, r = np.asarray(renders, np.float64), np.asarray(references, np.float64)
    if x.shape != r.shape or len(x) < 2:
        raise ValueError(f"flicker needs two walks of at least two frames, got {x.shape} and {r.shape}")
    mean = float(r.mean())
    change, own = (float(np.abs(np.diff(frames, axis=0)).mean()) / mean for frames in (x, r))
    error_change = float(np.abs(np.diff(x - r, axis=0)).mean()) / mean
    return Flicker(change, own, change - own, error_change)


@dataclass(frozen=True)
class ErrorParts:
    """relMSE told apart into bias, which stays however many seeds are averaged, and noise, which differs between them.

    vpl: of VPLs without clustering, against the reference (disks, lost near field; one set of VPLs); clustering: of
    what clustering adds to that; total: of the clustered render, less than the sum where clustering smooths the VPLs'
    noise. reference_noise is the reference's own, which the biases against it are free of when it is known.
    """

    vpl_bias: float
    vpl_noise: float
    clustering_bias: float
    clustering_noise: float
    total_bias: float
    total_noise: float
    reference_noise: float


def tell_apart(clustered: Images, exact: Images, reference: ArrayLike, reference_noise: float = 0.0) -> ErrorParts:
    """Split the relMSE of `clustered` renders, whose VPLs `exact` renders use unclustered, one pair a seed.

    With weights 1 / (r² + 0.01·mean(r)²), the mean square of n renders' error is that of their mean plus their
    variance; the mean's own square holds 1/n of the variance, which is taken out.
    """
    f, e, r = (np.asarray(images, np.float64) for images in (clustered, exact, reference))
    if len(f) < 2 or f.shape != e.shape:
        raise ValueError(f"errors are told apart by pairs of renders of at least two seeds, got {f.shape}, {e.shape}")
    weight = 1.0 / (r**2 + 0.01 * np.mean(r) ** 2)
    vpl_bias, vpl_noise = _bias_and_noise(e - r, weight)
    total_bias, total_noise = _bias_and_noise(f - r, weight)
    return ErrorParts(
        vpl_bias - reference_noise,
        vpl_noise,
        *_bias_and_noise(f - e, weight),
        total_bias - reference_noise,
        total_noise,
        reference_noise,
    )


def bias_and_noise(renders: Images, reference: ArrayLike) -> tuple[float, float]:
    """The relMSE of renders, one a seed, told apart: of what they have in common, and of what differs between them."""
    x, r = np.asarray(renders, np.float64), np.asarray(reference, np.float64)
    return _bias_and_noise(x - r, 1.0 / (r**2 + 0.01 * np.mean(r) ** 2))


def _bias_and_noise(errors: NDArray[np.float64], weight: NDArray[np.float64]) -> tuple[float, float]:
    """The weighted square of the errors' mean over seeds, without their noise, and their variance."""
    noise = float(np.mean(errors.var(axis=0, ddof=1) * weight))
    return float(np.mean(errors.mean(axis=0) ** 2 * weight)) - noise / len(errors), noise
