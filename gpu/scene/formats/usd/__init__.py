"""USD scenes (.usd, .usda, .usdc, .usdz), read with usd-core, an extra: https://openusd.org/release/api/index.html."""

from pathlib import Path

from gpu.scene.formats.extras import library
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import Scene


def load_usd(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the USD file at `path`, with the variants that it selects, at its first time.

    Raises SceneError, naming the prim, for what is broken or too large, for a file outside the scene's folder, and
    where usd-core is not installed.
    """
    library(str(path), "pxr", "usd")
    from gpu.scene.formats.usd.reader import read_scene

    return read_scene(path, limits, options)
