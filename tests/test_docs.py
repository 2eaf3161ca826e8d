import re
import shlex
from argparse import ArgumentParser
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

from gpu.methods.registry import METHODS
from gpu.renderer import MAX_SIDE
from gpu.scene import edits
from gpu.settings import Method, RenderSettings, Skips
from server import jobs, service
from server.cli.commands import parser as lumenwalk_parser
from server.http import connection, http_protocol, metered, middleware
from server.rest import render, requests
from server.scenes import archives, checker, uploads
from server.settings import ServerSettings
from server.walk import stream, viewer
from server.wire import camera_path
from tests.bench.__main__ import PARTS
from tests.bench.__main__ import parser as bench_parser
from tests.load.options import parser as load_parser
from tests.server.test_imports import SERVER
from tests.test_structure import GPU

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "docker").glob("*.md")])
WRITTEN = [page for page in PAGES if not page.name.startswith(("results", "options"))]
# What was tried names files, too; the page of results has it as it is.
NAMING = [*WRITTEN, *ROOT.glob("tests/bench/results/*/tried.md")]
METHOD, ARCHITECTURE = (ROOT / "docs" / name for name in ("method.md", "architecture.md"))
FOLDERS = ("gpu", "server", "web", "tests", "docs", "docker")


def _name(page: Path) -> str:
    return str(page.relative_to(ROOT))


def _anchors(page: Path) -> set[str]:
    """GitHub's: headings in lower case, without punctuation, with dashes for spaces."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_links_resolve(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if "://" not in link:
            path, _, anchor = link.partition("#")
            target = page.parent / path if path else page
            assert target.exists(), link
            assert not anchor or anchor in _anchors(target), link


@pytest.mark.parametrize("page", NAMING, ids=_name)
def test_files_named_exist(page: Path) -> None:
    for name in re.findall(r"`([\w./-]+/[\w./-]*)`", page.read_text()):
        if name.split("/")[0] in FOLDERS:
            assert (ROOT / name).exists() or name in ("tests/gpu/PACKAGE/test_X.py", "gpu/PACKAGE/X.py"), name
        elif name.endswith(".py"):
            assert any(
                (ROOT / folder / name).exists() for folder in ("gpu", "gpu/scene", "gpu/vpl", "gpu/sp", "server")
            ), name


@pytest.mark.parametrize("page", WRITTEN, ids=_name)
def test_settings_named_exist(page: Path) -> None:
    models = {*RenderSettings.model_fields, *ServerSettings.model_fields}
    for flag in re.findall(
        r"`--(max-[a-z-]+|target-[a-z]+|[a-z]+-clusters|[a-z]+-seconds|[a-z]+-bytes)`", page.read_text()
    ):
        assert flag.replace("-", "_") in models, flag


def test_methods_and_skips_are_explained() -> None:
    text = METHOD.read_text()
    assert all(f"`{name}`" in text for name in [*METHODS, *Skips.model_fields])
    table = text.split("## What is left out")[1].split("\n## ")[0]
    rows = {
        name for line in table.splitlines() for name in re.findall(r"`(\w+)`", line.split(" | ")[0]) if line[0:1] == "|"
    }
    assert rows == set(Skips.model_fields)


@pytest.mark.parametrize(("part", "layers"), [("gpu", GPU), ("server", SERVER)])
def test_the_architecture_has_every_package_in_its_layer(part: str, layers: list[list[str]]) -> None:
    text = ARCHITECTURE.read_text().split(f"## Packages of {part}/")[1].split("\n## ")[0]
    shown: list[set[str]] = []
    for line in text.split("|---|---|---|\n")[1].splitlines():
        if line.startswith("|"):
            _, layer, packages, _, _ = line.split("|")
            if layer.strip():
                shown.append(set())
            shown[-1] |= set(re.findall(r"`(\w+)(?:/|\.py)`", packages))
    assert shown == [set(layer) for layer in layers]


def test_every_stage_is_in_the_architecture() -> None:
    text = ARCHITECTURE.read_text().split("## The way of a frame")[1].split("\n## ")[0]
    cells = " ".join(line.split(" | ")[0] for line in text.splitlines() if line.startswith("| `"))
    assert {*re.findall(r"`([\w-]+)`", cells)} == {*METHODS[Method.FUZZY_VPL].stage_names, "display"}
    assert all(f"`{stage}`" in text for method in METHODS.values() for stage in method.stage_names)


def test_parts_of_the_benchmark_named_exist() -> None:
    text = "\n".join(page.read_text() for page in WRITTEN)
    named = {
        name for line in re.findall(r"python -m tests\.bench ([a-z ]+?)(?: --|`|\n)", text) for name in line.split()
    }
    assert named
    assert named <= set(PARTS)


@pytest.mark.parametrize(
    ("command", "parser"),
    [
        (r"lumenwalk (?=serve|render|compare|info|warm)", lumenwalk_parser),
        (r"python -m tests\.bench ", bench_parser),
        (r"python -m tests\.load ", load_parser),
    ],
)
def test_commands_named_are_understood(command: str, parser: Callable[[], ArgumentParser]) -> None:
    text = "\n".join(page.read_text().replace("\\\n", " ") for page in WRITTEN)
    commands = re.findall(rf"^(?:    )?(?:[A-Z_]+=\S+ )*{command}(.+)$", text, re.M)
    assert len(commands) > 3
    for arguments in commands:
        parser().parse_args(shlex.split(arguments, comments=True))


def test_modules_named_exist() -> None:
    named = {name for page in WRITTEN for name in re.findall(r"python -m (tests\.[\w.]*\w)", page.read_text())}
    assert "tests.bench.sparse" in named
    assert all(find_spec(name) for name in named)


@pytest.mark.parametrize(
    "sentence",
    [
        f"An archive may hold {archives.MAX_FILES} files, {archives.MAX_DEPTH} folders deep, and unpack to at most "
        f"{archives.MAX_RATIO} times its size",
        f"Sides are 1 to {MAX_SIDE:,} pixels",
        f"says hello within {stream.HELLO_SECONDS:.0f} s",
        f"acknowledges no frame for {viewer.STALLED_SECONDS:.0f} s is closed",
        f"arrives within {middleware.BODY_SECONDS:.0f} s; an upload may not pause for longer",
        f"nor bring less than {uploads.MIN_RATE:,} bytes a second",
        f"head comes within {connection.REQUEST_SECONDS:.0f} s and has up to {http_protocol.MAX_HEAD_BYTES:,} bytes, "
        f"{http_protocol.MAX_PATH_BYTES:,} of them for its path, and up to {http_protocol.MAX_PARTS} headers",
        f"keep the web process for {service.EFFORT_RATE / 1e3:g} s of a second (a turn of "
        f"{1e3 * metered.FREE_SECONDS:g} ms is free), and {service.EFFORT_BURST / 1e3:g} s at once",
        f"less than {connection.UNREAD_BYTES:,} bytes are read in {connection.UNREAD_SECONDS:.0f} s",
        f"{service.MAX_STREAMS} event streams, {service.MAX_STREAMS_OF_ONE} for one client",
        f"averages at most {render.MAX_FRAMES} frames",
        f"path tracing counts one for each {requests.SAMPLES_A_FRAME} samples",
        f"Two scene files are read at a time, and {checker.MAX_WAITING} may be read or wait",
        f"`date` (of {edits.FIRST_YEAR} to {edits.LAST_YEAR})",
        f"{uploads.MAX_AT_ONCE} uploads may arrive at a time",
        f"2 to {camera_path.MAX_KEYFRAMES} keyframes, up to {camera_path.MAX_SECONDS:.0f} s and "
        f"{camera_path.MAX_PICTURES:,} pictures",
    ],
)
def test_limits_are_those_of_the_code(sentence: str) -> None:
    pages = [" ".join((ROOT / "docs" / name).read_text().split()) for name in ("limits.md", "formats.md", "service.md")]
    assert any(sentence in page for page in pages)
    assert checker.AT_ONCE == service.WAITING_OF_ALL == jobs.OF_ALL == 2
    assert checker.MAX_WAITING == 2 * checker.MAX_WAITING_OF_ONE
    assert middleware.BODY_SECONDS == uploads.STALL_SECONDS
