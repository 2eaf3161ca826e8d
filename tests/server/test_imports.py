"""Imports inside server/ go down only, read from the source."""

import ast
from collections import deque
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# From the top: a package imports from packages below its own layer only; modules beside them are packages of their own.
SERVER = [
    ["cli", "cluster"],
    ["serve"],
    ["app"],
    ["walk", "rest"],
    ["http"],
    ["service"],
    ["jobs", "errors", "worker", "replicas", "engines"],
    ["scenes"],
    ["render"],
    ["settings", "metrics", "logs", "places", "rate_limit", "results"],
    ["wire"],
    ["images", "video", "refusals", "addresses", "folders", "plain_files", "importing"],
    ["srgb_profile", "png"],
]
LAYERS = {package: number for number, packages in enumerate(SERVER) for package in packages}


def name_of(file: Path) -> str:
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {name_of(file): file for file in sorted((ROOT / "server").rglob("*.py"))}


@cache
def imports_of(module: str) -> frozenset[str]:
    """The modules of the service that a module names in imports, at its top or within functions."""
    found = set[str]()
    for node in ast.walk(ast.parse(MODULES[module].read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    packages = {name for name, file in MODULES.items() if file.stem == "__init__"}
    return frozenset(found & MODULES.keys() - packages)


def package_of(module: str) -> str:
    return module.split(".")[1]


def test_every_package_has_a_layer() -> None:
    assert {package_of(module) for module in MODULES if module != "server"} == LAYERS.keys()


@pytest.mark.parametrize("module", [module for module in MODULES if module != "server"])
def test_imports_go_down(module: str) -> None:
    package = package_of(module)
    for other in imports_of(module):
        assert package_of(other) == package or LAYERS[package_of(other)] > LAYERS[package], f"{module} imports {other}"


def test_no_module_imports_itself_by_others() -> None:
    for module in MODULES:
        reached, ways = set[str](), deque(imports_of(module))
        while ways:
            step = ways.popleft()
            assert step != module, f"{module} is imported by what it imports"
            if step not in reached:
                reached.add(step)
                ways.extend(imports_of(step))
