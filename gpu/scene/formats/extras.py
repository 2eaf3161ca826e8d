"""Libraries of formats that not every installation reads."""

from importlib import import_module
from types import ModuleType

from gpu.errors import SceneError


def library(source: str, module: str, extra: str) -> ModuleType:
    """The `module` that reads the file `source`. Raises SceneError naming the `extra` that would install it."""
    try:
        return import_module(module)
    except ImportError as error:
        raise SceneError(source, "", f"needs the extra {extra}: pip install lumenwalk[{extra}]") from error
