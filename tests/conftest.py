import gc
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import warp as wp

from gpu.scene.default_view import default_camera
from gpu.scene.types import Camera, Floats, Integers, Mask, Placement

# Threads of FLIP that have nothing to do would spin on cores that others want: 0.1 s for each small picture.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

TESTS = Path(__file__).parent
# The files that take longest, the longest first: processes that begin with them end at about the same time. A folder's
# files follow on one another: a process that runs several shares what is made for the folder.
LONGEST = (
    "load/test_faults.py",
    "server/scenes/test_uploads_corpus.py",
    "stability/test_reference.py",
    "gpu/methods/test_registry.py",
    "server/render/test_engine.py",
    "gpu/methods/test_targeted_vpl.py",
    "bench/test_suite.py",
    "browser",
    "bench/test_gate.py",
    "gpu/methods/test_caustics.py",
    "server/rest/test_scenes.py",
    "gpu/methods/test_fuzzy_lights.py",
    "server/scenes/test_check_scene.py",
    "server/scenes/test_residency.py",
    "gpu/scene/formats/gltf/test_corpus.py",
    "stability/test_light.py",
    "stability/test_geometry.py",
    "gpu/methods/test_fuzzy_statistics.py",
    "load/test_fault_worker.py",
    "server/http/test_shutdown.py",
    "server/walk/test_stream.py",
    "gpu/correction/test_visibility_correction.py",
    "server/rest/test_health.py",
    "stability/test_furnace.py",
    "stability/test_edits.py",
    "stability/test_repetition.py",
    "stability/test_surfaces.py",
    "stability/test_leaks.py",
    "stability/test_invariance.py",
    "stability/test_rooms.py",
    "server/worker/test_backend.py",
    "server/walk/test_viewer.py",
    "server/scenes/test_uploads.py",
    "server/render/test_worker_link.py",
    "server/render/test_asking_back.py",
    "server/rest/test_render.py",
    "load/test_soak.py",
    "gpu/core/test_kernel_loading.py",
    "gpu/film/test_accumulation.py",
    "gpu/indirect/test_near_field.py",
    "gpu/indirect/test_frosted_glass.py",
    "gpu/correction/test_outlier_shading.py",
    "gpu/denoise/test_indirect_history.py",
    "gpu/direct/test_path_tracing.py",
    "server/test_proxies.py",
    "server/test_schema.py",
    "fuzz/test_readers.py",
    "test_scale.py",
    "test_structure.py",
)


# New objects after which Python looks for garbage that refers to itself: after 700, that takes a tenth of all time.
gc.set_threshold(10_000)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    places = {TESTS / name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path, places.get(item.path.parent, len(places))))


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("cuda") and not wp.is_cuda_available():
        pytest.skip("needs a CUDA device")


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


@pytest.fixture(scope="session", autouse=True)
def views() -> Iterator[None]:
    """Thousands of tests have one of a few hundred scenes without a camera: the view of each is looked for once."""
    found: dict[tuple[Any, ...], Camera] = {}

    def view(vertices: Floats, triangles: Integers, placement: Placement, glass: Mask) -> Camera:
        key = placement, *(hash(array.tobytes()) for array in (vertices, triangles, glass))
        if key not in found:
            found[key] = default_camera(vertices, triangles, placement, glass)
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gpu.scene.assemble.default_camera", view)
        yield


@pytest.fixture(scope="session")
def cpu() -> str:
    """The device that every machine has; tests run on it unless they are about another."""
    return "cpu"
