import gc
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
# The files that take longest, the longest first: processes that begin with them end at about the same time.
LONGEST = (
    "load/test_faults.py",
    "server/scenes/test_uploads_corpus.py",
    "server/render/test_engine.py",
    "bench/test_suite.py",
    "gpu/methods/test_targeted_vpl.py",
    "gpu/methods/test_registry.py",
    "browser/test_page.py",
    "browser/test_picture.py",
    "browser/test_views.py",
    "server/test_proxies.py",
    "server/test_schema.py",
    "server/scenes/test_check_scene.py",
    "gpu/methods/test_fuzzy_lights.py",
    "gpu/methods/test_fuzzy_view_state.py",
    "gpu/methods/test_fuzzy_statistics.py",
    "gpu/scene/gltf/test_corpus.py",
    "bench/test_gate.py",
    "stability/test_invariance.py",
    "server/worker/test_worker.py",
    "server/worker/test_backend.py",
    "server/scenes/test_residency.py",
    "load/test_fault_worker.py",
    "fuzz/test_readers.py",
    "gpu/adaptive/test_error_probes.py",
    "stability/test_repetition.py",
    "stability/test_edits.py",
    "stability/test_geometry.py",
    "server/http/test_shutdown.py",
    "test_scale.py",
    "test_structure.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    places = {TESTS / name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path, len(places)))


def pytest_collection_finish() -> None:
    """Half a million objects that the tests import stay: no collection of garbage need look at them again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of test scenes, references and samples beside the repository; without it the test is skipped."""
    folder = Path(__file__).resolve().parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip(f"needs the scenes and references of {folder}")
    return folder


@pytest.fixture(scope="session")
def cpu() -> str:
    """The device that every machine has; tests run on it unless they are about another."""
    return "cpu"
