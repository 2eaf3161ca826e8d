"""Which kernels the renderer behind the border shows scenes and edits by, tiny and on the CPU."""

from dataclasses import replace
from unittest.mock import create_autospec

import pytest

from gpu.core.kernel_loading import LateKernels
from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import LightEdit, MaterialEdit, SceneEdits
from gpu.scene.types import Floats
from gpu.settings import Component, RenderSettings
from server.wire.worker import Output, Render, SceneCamera, SceneRef, Start
from server.worker.backend import GpuBackend
from server.worker.tasks import CancelledError, Tasks

BOX, TWIN = (SceneRef(name, "cornell-box") for name in ("box", "twin"))
SETTINGS = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)


def silent(_: str, __: float) -> None:
    pass


def job(viewer: int = 1, scene: SceneRef = BOX, settings: RenderSettings = SETTINGS, output: Output = "jpeg") -> Render:
    return Render(viewer, scene, SceneCamera(0), (32, 18), settings, output)


@pytest.fixture(scope="module")
def backend(cpu: str) -> GpuBackend:
    backend = GpuBackend()
    assert backend.start(Start(BOX, cpu, max_scenes=2), silent, Tasks()) == cpu
    return backend


def test_a_scene_is_warmed_before_it_is_shown(backend: GpuBackend, monkeypatch: pytest.MonkeyPatch) -> None:
    warmed: list[DeviceScene] = []
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda scene, _: warmed.append(scene))
    backend.close(TWIN)
    for _ in range(2):
        backend.open(TWIN, silent)
    assert warmed == [backend._scenes[TWIN].device_scene]


@pytest.mark.parametrize("fails", [False, True])
def test_a_scene_is_shown_by_general_kernels_until_its_own_are_there(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch, *, fails: bool
) -> None:
    late = create_autospec(LateKernels, instance=True, compiled=False)
    late.load.side_effect = RuntimeError("of a compiler") if fails else None
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda *_: late)
    backend.close(TWIN)
    settings = SETTINGS.model_copy(update={"component": Component.DIRECT})
    walk = replace(job(scene=TWIN, settings=settings, output=".npy"), walks=True)
    dimmed = replace(walk, viewer=3, edits=SceneEdits(lights={"light": LightEdit(intensity=0.25)}))

    def pictures(sample: int) -> list[Floats]:
        """Of a walk, of a view that rests, and of a walk with edits."""
        shown = [
            backend.render(it, silent) for it in (walk, replace(walk, viewer=2, walks=False, sample=sample), dimmed)
        ]
        assert shown[1].samples == sample + 1
        return [it.radiance for it in shown if it.radiance is not None]

    def states() -> set[int]:
        return {key.state for key in backend._renderers._entries if key.scene == TWIN}

    before, made = pictures(0), states()
    assert backend._scenes[TWIN].device_scene.general
    late.compiled = True
    for one, other in zip(before, pictures(1), strict=True):
        assert one.mean() > 0.0
        assert other.mean() == pytest.approx(one.mean(), rel=0.1)
    assert (backend._scenes[TWIN].device_scene.general, late.load.call_count) == (fails, 1)
    assert len(states()) == len(made) == 2
    assert states().isdisjoint(made) != fails
    backend.close(TWIN)


def test_kernels_are_loaded_by_the_next_job_where_one_ends_while_it_loads_them(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    late = create_autospec(LateKernels, instance=True, compiled=True)
    late.load.side_effect = [CancelledError, None]
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda *_: late)
    backend.close(TWIN)
    backend.open(TWIN, silent)
    with pytest.raises(CancelledError):
        backend.open(TWIN, silent)
    assert backend._scenes[TWIN].device_scene.general
    backend.open(TWIN, silent)
    assert not backend._scenes[TWIN].device_scene.general
    backend.close(TWIN)


def test_kernels_that_only_edits_need_are_loaded_side_by_side_once(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[str] = []
    backend.open(BOX, silent)
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda scene, settings: heard.append("warm"))
    for edits in (
        SceneEdits(lights={"light": LightEdit(intensity=0.25)}),
        SceneEdits(materials={"red": MaterialEdit(metallic=1.0, roughness=0.1)}),
        SceneEdits(materials={"red": MaterialEdit(metallic=1.0, roughness=0.11)}),
    ):
        with backend._state(BOX, edits, 1, silent):
            pass
    assert heard == ["warm"]


@pytest.mark.parametrize("fails", [False, True])
def test_edits_are_shown_by_general_kernels_until_their_own_are_there(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch, *, fails: bool
) -> None:
    late = create_autospec(LateKernels, instance=True, compiled=False)
    late.load.side_effect = RuntimeError("of a compiler") if fails else None
    settings = SETTINGS.model_copy(update={"component": Component.DIRECT})

    def picture(roughness: float) -> Floats:
        edits = SceneEdits(materials={"green": MaterialEdit(metallic=1.0, roughness=roughness)})
        walk = replace(job(viewer=7, settings=settings, output=".npy"), walks=True, edits=edits)
        radiance = backend.render(walk, silent).radiance
        assert radiance is not None
        return radiance

    def is_general() -> bool:
        (state,) = backend._states._states[BOX, None]
        return state.loaded.device_scene.general

    backend.close(BOX)
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda *_: None)
    backend.open(BOX, silent)
    monkeypatch.setattr(backend, "_warm", set())
    monkeypatch.setattr("server.worker.late_edits.compile_soon", lambda *_: None)
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda *_: late)
    before = picture(0.3)
    assert is_general()
    picture(0.31)  # in the arrays of the one before
    assert is_general()
    assert not backend._scenes[BOX].device_scene.general
    late.compiled = True
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda *_: None)
    after = picture(0.3)
    assert (is_general(), late.load.call_count) == (fails, 1)
    assert after.mean() == pytest.approx(before.mean(), rel=0.1)
    backend.close(BOX)
