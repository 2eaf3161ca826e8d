"""Broken and odd files, uploaded over HTTP to a service with its real checker and its real renderer on the CPU.

A part of them, the same each time; LUMENWALK_CORPUS=all in the environment takes every file and 1000 mutations.
"""

import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import monotonic

import httpx
import pytest
from corpus import Case, malformed, mutated, samples
from harness import Running, run

from server.render.worker_process import WORKER
from server.scenes.checker import CHECK
from server.settings import ServerSettings

ALL = os.environ.get("LUMENWALK_CORPUS") == "all"
FEW = range(11, 15)  # three load, whose kernels are those of the samples below
SECONDS = 30.0  # that an answer may take
# Valid files, but with nothing that could be rendered here: no surfaces, or a later glTF.
NOTHING_TO_RENDER = re.compile(r"no triangles|has an area|has no 'uri'|only 2\.0 is read")
pytestmark = pytest.mark.timeout(7200 if ALL else 900)


@pytest.fixture(scope="module")
def real() -> Iterator[Running]:
    """A service with nothing replaced."""
    with run(ServerSettings(port=0, device="cpu", max_scenes=2), WORKER, CHECK) as service:
        service.wait_ready(120.0)
        yield service


def part(cases: Sequence[Case], count: int) -> Sequence[Case]:
    """All of them, or about `count` spread over all."""
    return cases if ALL else cases[:: max(len(cases) // count, 1)]


def upload(service: Running, case: Case) -> httpx.Response:
    began = monotonic()
    response = service.http.post(
        "/api/v1/scenes", params={"name": case.name}, content=case.content, timeout=2 * SECONDS
    )
    assert monotonic() - began < SECONDS, case.name
    return response


def render(service: Running, scene_id: str) -> str:
    """Render an upload, delete it, and return the problem that there was."""
    settings = {"vpls": 256, "vpl_clusters": 16, "sp_clusters": 64, "lambertian": not ALL}  # by few kernels
    request = {"scene": scene_id, "size": [64, 36], "settings": settings}
    response = service.http.post("/api/v1/render", json=request, timeout=300)  # kernels, too
    service.http.post(f"/api/v1/scenes/{scene_id}/unload", timeout=60)
    assert service.http.delete(f"/api/v1/scenes/{scene_id}").status_code == 204
    return "" if response.status_code == 200 else f"{scene_id}: {response.status_code} {response.text}"


def outcomes(service: Running, cases: Sequence[Case]) -> tuple[Counter[int], list[str]]:
    """How many uploads had each status; what is wrong with answers and renders."""

    def tried(case: Case) -> tuple[int, str]:
        response = upload(service, case)
        if response.status_code == 201:
            return 201, render(service, response.json()["id"])
        message = response.json()["message"]
        named = message.startswith(Path(case.name).stem) and len(message) > len(case.name) + 10
        sound = case.valid and not NOTHING_TO_RENDER.search(message)
        wrong = response.status_code != 422 or not named or "/" in message.split(":")[0] or sound
        return response.status_code, f"{case.name}: {response.status_code} {message}" if wrong else ""

    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(tried, cases))
    return Counter(status for status, _ in answers), [problem for _, problem in answers if problem]


def check(service: Running, cases: Sequence[Case]) -> Counter[int]:
    statuses, problems = outcomes(service, cases)
    print(statuses)
    assert problems == []
    assert service.service.engines.restarts == 0
    assert service.http.get("/readyz").status_code == 200
    return statuses


def test_malformed_files_are_refused_with_their_problem(real: Running, shared: Path) -> None:
    cases = malformed(shared)
    assert len(cases) > 300
    check(real, part([case for case in cases if not case.valid], 5))


def test_valid_files_load_if_there_is_anything_in_them(real: Running, shared: Path) -> None:
    check(real, part([case for case in malformed(shared) if case.valid], 3))


def test_mutated_files_load_or_are_refused(real: Running, shared: Path) -> None:
    statuses = check(real, list(mutated(shared, range(1000) if ALL else FEW)))
    assert set(statuses) == {201, 422}


def test_samples_load_and_render(real: Running, shared: Path) -> None:
    statuses = check(real, part(samples(shared), 3))
    assert statuses[201] > 3 * statuses[422]


def test_what_is_ignored_in_a_sample_is_said(real: Running, shared: Path) -> None:
    case = next(case for case in samples(shared) if case.name.startswith("TransmissionTest"))
    notes = upload(real, case).json()["scene"]["notes"]
    assert any("KHR_xmp" in note for note in notes)
