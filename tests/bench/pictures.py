"""Pictures of `fuzzy-vpl` beside their references, with maps of error, small enough to be rows of a results file."""

import base64
from functools import partial
from io import BytesIO

import numpy as np
from PIL import Image

from gpu.scene.types import Bytes, Floats
from gpu.settings import Component
from tests.bench import paper
from tests.bench.store import Row, Task
from tests.bench.suite import CLUSTERS, VPLS, Suite
from tests.bench.sweep import MOST_EXACT_VPLS, title

WIDEST, QUALITY = 400, 88
# Error maps hold log10 of the relative squared error between these, in the steps of a byte.
LEAST_DECADE, MOST_DECADE = -5.0, 1.0
COARSE = paper.SETTINGS[0]
SETTINGS = (
    {**CLUSTERS, "vpls": VPLS},
    {"sp_clusters": COARSE[0], "vpl_clusters": COARSE[1], "vpls": paper.VPLS},
)


def shrunk(image: Floats) -> Floats:
    """`image` by whole pixels averaged, at most WIDEST wide."""
    step = -(-image.shape[1] // WIDEST)
    height, width = image.shape[0] // step * step, image.shape[1] // step * step
    blocks = image[:height, :width].reshape(height // step, step, width // step, step, 3)
    return np.asarray(blocks.mean(axis=(1, 3)), np.float32)


def displayed(image: Floats, white: float) -> Bytes:
    """sRGB of linear radiance with `white` at full (IEC 61966-2-1)."""
    x = np.clip(image / white, 0.0, 1.0)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.rint(255.0 * encoded), np.uint8)


def error_map(render: Floats, reference: Floats) -> Bytes:
    """Relative squared error of each pixel, the mean of its channels, as (height, width) bytes of its logarithm."""
    error = (render - reference) ** 2 / (reference**2 + 0.01 * np.mean(reference) ** 2)
    decade = np.log10(np.maximum(error.mean(axis=2), 10.0**LEAST_DECADE))
    share = (decade - LEAST_DECADE) / (MOST_DECADE - LEAST_DECADE)
    return np.asarray(np.rint(255.0 * np.clip(share, 0.0, 1.0)), np.uint8)


def encoded(pixels: Bytes) -> str:
    """A JPEG in base64."""
    file = BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=QUALITY, subsampling=0, optimize=True)
    return base64.b64encode(file.getvalue()).decode()


def decoded(text: str) -> Bytes:
    """The pixels of `encoded`."""
    return np.asarray(Image.open(BytesIO(base64.b64decode(text))))


def measure_row(suite: Suite, name: str, counts: dict[str, int]) -> Row:
    """A render, its two references, and its errors against both."""
    subject = suite.subject(name)
    settings = suite.settings(**counts)
    render, reference = subject.render(settings), subject.reference(Component.INDIRECT).image
    white = float(np.percentile(reference, 99))
    row = {
        "scene": name,
        "size": list(subject.size),
        "settings": settings.model_dump(mode="json"),
        "render": encoded(displayed(shrunk(render), white)),
        "reference": encoded(displayed(shrunk(reference), white)),
        "total_error": encoded(error_map(shrunk(render), shrunk(reference))),
    }
    if counts["vpls"] <= MOST_EXACT_VPLS:
        bare = settings.model_copy(update={"near_field": False})
        images = subject.render(bare), subject.exact(bare).image
        row["clustering_error"] = encoded(error_map(*map(shrunk, images)))
    return row


def run(suite: Suite) -> None:
    """The part of the command line."""
    choices = [{key: suite.count(number) for key, number in counts.items()} for counts in SETTINGS]
    tasks = [
        Task(f"{suite.label(name)} {title(suite.settings(**counts))}", partial(measure_row, suite, name, counts))
        for counts in choices
        for name in suite.scene_names()
    ]
    suite.run("pictures", tasks)
