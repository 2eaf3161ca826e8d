"""What the container's files promise: everything fetched is checked, nothing runs from the scenes, no privileges."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCKERFILE = (ROOT / "docker" / "Dockerfile").read_text().replace("\\\n", " ")
COMPOSE = (ROOT / "docker" / "compose.yaml").read_text()


def test_the_base_is_named_by_its_digest() -> None:
    (base,) = re.findall(r"^ARG BASE=(.*)$", DOCKERFILE, re.M)
    assert re.fullmatch(r"debian:[\w-]+@sha256:[0-9a-f]{64}", base)
    stages = re.findall(r"^FROM (\S+)(?: AS (\S+))?$", DOCKERFILE, re.M)
    assert {source for source, _ in stages} <= {"$BASE", *(name for _, name in stages)}


def test_packages_of_python_are_checked_by_hash() -> None:
    installs = re.findall(r"pip install ([^&\n]*)", DOCKERFILE)
    assert installs
    for arguments in installs:
        assert "--require-hashes" in arguments or "--no-deps --no-build-isolation ." in arguments
    for name in re.findall(r"--requirement (\S+)", DOCKERFILE):
        requirements = re.findall(r"^\S+==\S+.*?(?=^\S|\Z)", (ROOT / name).read_text(), re.M | re.S)
        assert requirements
        assert all("--hash=sha256:" in requirement for requirement in requirements)
        assert f"!{name}" in (ROOT / ".dockerignore").read_text().splitlines()


def test_what_builds_is_what_the_tests_were_run_with() -> None:
    lines = (ROOT / "requirements-build.lock").read_text().splitlines()
    tested = (ROOT / "requirements-dev.lock").read_text().splitlines()
    assert next(line for line in lines if not line.startswith("#")) in tested


def test_nothing_runs_from_the_folder_of_scenes() -> None:
    assert re.findall(r"^WORKDIR (.*)$", DOCKERFILE, re.M)[-1] == "/"
    (entry,) = re.findall(r"^ENTRYPOINT (.*)$", DOCKERFILE, re.M)
    (health,) = re.findall(r"HEALTHCHECK .*CMD (\[.*\])$", DOCKERFILE, re.M)
    assert [json.loads(command)[:2] for command in (entry, health)] == [["python3", "-I"]] * 2
    assert "- python3\n        - -I\n" in COMPOSE


@pytest.mark.parametrize(
    "line",
    [
        "read_only: true",
        "cap_drop: [ALL]",
        'security_opt: ["no-new-privileges:true"]',
        "${SCENES:-./scenes}:/scenes:ro",
    ],
)
def test_the_container_has_no_privileges(line: str) -> None:
    assert line in COMPOSE
    assert re.findall(r"^USER (.*)$", DOCKERFILE, re.M) == ["lumenwalk"]


def test_uploads_fit_the_memory_that_they_are_kept_in() -> None:
    (gigabytes,) = re.findall(r"/tmp:size=(\d+)g", COMPOSE)
    (uploads,) = re.findall(r"LUMENWALK_MAX_UPLOADS_BYTES: (\d+)", COMPOSE)
    assert int(uploads) < 0.75 * int(gigabytes) * 2**30
