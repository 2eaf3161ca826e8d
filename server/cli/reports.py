"""What `lumenwalk compare` and `lumenwalk info` print."""

import json
from dataclasses import asdict
from math import isnan
from pathlib import Path

from gpu.errors import ImageError
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.settings import Component
from server.images import read_image


def report_errors(render: str, reference: str, component: Component, *, as_json: bool) -> int:
    """Print the errors of the image file `render` against `reference`; return 1 for non-finite values, else 0.

    `component` chooses from an .npz. Raises ImageError when one cannot be read or they cannot be compared.
    """
    from gpu.film.metrics import measure

    images = [read_image(Path(file), component) for file in (render, reference)]
    try:
        errors = measure(*images)
    except ImageError as error:
        raise ImageError(f"{render}, {reference}: {error}") from None
    values = {name: None if isnan(value) else value for name, value in asdict(errors).items()}
    if as_json:
        print(json.dumps({"render": render, "reference": reference, "component": component.value, **values}, indent=2))
    else:
        labels = {"nonfinite": "non-finite", "mse": "MSE", "rel_mse": "relMSE", "flip": "HDR-FLIP", "energy": "energy"}
        for name, label in labels.items():
            value = values[name]
            print(f"{label:<12}{'-' if value is None else f'{value:.4g}'}")
    return 1 if errors.nonfinite else 0


def report_scene(source: str, reading: ImportOptions = DEFAULT_OPTIONS, *, as_json: bool) -> None:
    """Print what is in the scene `source`, a built-in name or a file, read as told.

    Raises UserError when it cannot be loaded.
    """
    from gpu.scene.summary import summarise, summary_text
    from server.cli.reading import read_scene

    summary = summarise(read_scene(source, reading))
    print(json.dumps(summary, indent=2, ensure_ascii=False) if as_json else summary_text(summary))
