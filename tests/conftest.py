import gc
from pathlib import Path

import pytest


def pytest_collection_finish() -> None:
    """What a run has imported and collected, half a million objects, stays: no later collection of garbage reads it."""
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
