"""Scenes that need no file: each is made in a few seconds from NumPy alone, and always the same."""

from collections.abc import Callable
from importlib import import_module

from gpu.scene.types import Scene


def _maker(module: str) -> Callable[[], Scene]:
    def make() -> Scene:
        scene: Scene = import_module(f"gpu.scene.builtin.{module}").make()
        import_module("gpu.scene.builtin.textures").forget()
        return scene

    return make


_NAMES = ("conference-room", "living-room", "atrium", "cornell-box", "glass-box", "water-box")
BUILTIN: dict[str, Callable[[], Scene]] = {name: _maker(name.replace("-", "_")) for name in _NAMES}
MADE_AT_ONCE = frozenset({"cornell-box", "glass-box", "water-box"})
"""Those that take no longer than a process that would make them takes to start."""
