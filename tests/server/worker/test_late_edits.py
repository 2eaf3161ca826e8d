from itertools import count
from unittest.mock import create_autospec

import pytest

from gpu.core.kernel_loading import LateKernels
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.edits import NO_EDITS, LightEdit, MaterialEdit, SceneEdits
from gpu.vpl.light_sets import LightSets
from server.wire.worker import STILLS, SceneRef
from server.worker import late_edits
from server.worker.late_edits import COMPILING, LateEdits
from server.worker.loaded_scene import LoadedScene

DIM = SceneEdits(lights={"light": LightEdit(intensity=0.5)})
MIRROR = SceneEdits(materials={"white": MaterialEdit(metallic=1.0, roughness=0.0)})
GLOSSY = SceneEdits(materials={"white": MaterialEdit(metallic=1.0, roughness=0.3)})


def silent(_: str, __: float) -> None:
    pass


@pytest.fixture(scope="module")
def box(cpu: str) -> LoadedScene:
    scene = BUILTIN["cornell-box"]()
    device_scene = DeviceScene(scene, cpu)
    return LoadedScene(SceneRef("box", "cornell-box"), scene, device_scene, LightSets(device_scene), scene)


@pytest.fixture
def late(monkeypatch: pytest.MonkeyPatch) -> LateKernels:
    """What every edit that needs other kernels waits for."""
    late: LateKernels = create_autospec(LateKernels, instance=True, compiled=False)
    monkeypatch.setattr(late_edits, "compile_soon", lambda *_: late)
    return late


def test_who_walks_sees_what_it_saw_until_the_kernels_of_an_edit_are_there(box: LoadedScene, late: LateKernels) -> None:
    edits = LateEdits()
    assert edits.to_show(box, MIRROR, 1, silent, walks=True) == NO_EDITS
    assert edits.to_show(box, DIM, 2, silent, walks=True) == DIM
    assert edits.to_show(box, MIRROR, 2, silent, walks=True) == DIM
    edits.leave(2)
    assert edits.to_show(box, MIRROR, 2, silent, walks=True) == NO_EDITS
    late.compiled = True
    assert edits.to_show(box, MIRROR, 2, silent, walks=True) == MIRROR
    late.compiled = False
    assert edits.to_show(box, MIRROR, 3, silent, walks=True) == MIRROR
    assert edits.to_show(box, GLOSSY, 3, silent, walks=True) == MIRROR


def test_who_rests_waits_for_them(box: LoadedScene, late: LateKernels, monkeypatch: pytest.MonkeyPatch) -> None:
    def wait(_: float) -> None:
        late.compiled = True

    monkeypatch.setattr("gpu.core.sharing.sleep", wait)
    told: list[str] = []
    assert LateEdits().to_show(box, MIRROR, 1, lambda what, _: told.append(what), walks=False) == MIRROR
    assert late.compiled
    assert told == [COMPILING]


@pytest.mark.parametrize("walk", [MIRROR, DIM, None])
def test_who_moves_on_or_undoes_an_edit_does_not_wait_for_its_frame_at_rest(
    box: LoadedScene, late: LateKernels, monkeypatch: pytest.MonkeyPatch, walk: SceneEdits | None
) -> None:
    """Its frames are shown in the order in which they were asked for."""
    edits, slept = LateEdits(), count()

    def meanwhile(_: float) -> None:
        assert next(slept) == 0, "it waits on"
        if walk is None:
            edits.leave(1)
        else:
            assert edits.to_show(box, walk, 1, silent, walks=True) == DIM

    edits.to_show(box, DIM, 1, silent, walks=True)
    monkeypatch.setattr("gpu.core.sharing.sleep", meanwhile)
    assert edits.to_show(box, MIRROR, 1, silent, walks=False) == (NO_EDITS if walk is None else DIM)


def test_a_still_waits_whatever_others_are_asked_for(
    box: LoadedScene, late: LateKernels, monkeypatch: pytest.MonkeyPatch
) -> None:
    edits, slept = LateEdits(), count()

    def meanwhile(_: float) -> None:
        edits.leave(STILLS)
        late.compiled = next(slept) == 1

    monkeypatch.setattr("gpu.core.sharing.sleep", meanwhile)
    assert edits.to_show(box, MIRROR, STILLS, silent, walks=False) == MIRROR
    assert late.compiled


def test_what_a_viewer_saw_of_another_scene_is_not_shown(box: LoadedScene, late: LateKernels) -> None:
    edits = LateEdits()
    assert edits.to_show(box, DIM, 1, silent, walks=True) == DIM
    twin = LoadedScene(SceneRef("twin", "cornell-box"), box.scene, box.device_scene, box.light_sets, box.scene)
    assert edits.to_show(twin, MIRROR, 1, silent, walks=True) == NO_EDITS


def test_edits_of_what_is_not_there_are_refused(box: LoadedScene) -> None:
    with pytest.raises(UserError, match=r"materials\.glass: the scene has no such material"):
        LateEdits().to_show(box, SceneEdits(materials={"glass": MaterialEdit(roughness=0.3)}), 1, silent, walks=True)
