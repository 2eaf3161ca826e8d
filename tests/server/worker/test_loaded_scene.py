import pytest
import warp as wp

from gpu.device_scene.features import scene_features
from gpu.errors import UserError
from gpu.renderer import Renderer
from gpu.scene.edits import NO_EDITS, LightEdit, ObjectEdit, SceneEdits
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from server.wire.worker import SceneRef
from server.worker.loaded_scene import build, edit

SETTINGS = RenderSettings(sp_clusters=4, vpls=64, vpl_clusters=4)


def test_renderers_of_a_scene_trace_its_lights_once(cpu: str) -> None:
    loaded = build(SceneRef("box", "cornell-box"), load_scene("cornell-box"), wp.get_device(cpu))
    heard: list[str] = []
    shared = loaded.device_scene, (8, 8), SETTINGS, lambda what, _: heard.append(what), loaded.light_sets
    Renderer(*shared)
    assert "tracing virtual point lights" in heard
    heard.clear()
    Renderer(*shared)
    assert heard == []


def test_a_moved_object_stays_where_it_is_while_a_light_changes(cpu: str) -> None:
    """Its geometry is that of the state before, which goes on in its arrays; what cannot be is refused all the same."""
    loaded = build(SceneRef("box", "cornell-box"), load_scene("cornell-box"), wp.get_device(cpu))
    moved = {"light": ObjectEdit(offset=(0.02, 0.0, 0.0))}
    state = edit(loaded, SceneEdits(objects=moved))
    vertices = state.device_scene.data.vertices
    for intensity in (0.5, 0.25):
        edits = SceneEdits(objects=moved, lights={"light": LightEdit(intensity=intensity)})
        assert edit(loaded, edits, state) is state
        assert state.device_scene.data.vertices is vertices
        anew = edit(loaded, edits)
        assert (state.scene.vertices == anew.scene.vertices).all()
        assert state.scene.materials == anew.scene.materials
    with pytest.raises(UserError, match="has no such light"):
        edit(loaded, SceneEdits(objects=moved, lights={"moon": LightEdit(on=False)}), state)
    assert edit(loaded, NO_EDITS, state) is state  # whose arrays hold what the file has
    assert state.device_scene.data.vertices is vertices
    assert (vertices.numpy() == loaded.device_scene.data.vertices.numpy()).all()


def test_what_moves_while_something_is_hidden_does_so_in_place(cpu: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the trees that there are."""
    loaded = build(SceneRef("box", "cornell-box"), load_scene("cornell-box"), wp.get_device(cpu))
    hidden = next(one for one in loaded.scene.objects if one != "light")

    def edits(offset: float) -> SceneEdits:
        moved = ObjectEdit(offset=(offset, 0.0, 0.0))
        return SceneEdits(objects={hidden: ObjectEdit(visible=False), "light": moved})

    state = edit(loaded, edits(0.02))
    triangles = state.device_scene.data.triangles
    with monkeypatch.context() as patched:
        patched.delattr("gpu.device_scene.upload.tree_over")
        assert edit(loaded, edits(0.03), state) is state
    assert state.device_scene.data.triangles is triangles
    anew = edit(loaded, edits(0.03)).device_scene
    for name in ("vertices", "triangles", "triangle_material"):
        assert (getattr(state.device_scene.data, name).numpy() == getattr(anew.data, name).numpy()).all()
    other = edit(loaded, SceneEdits(objects={"light": ObjectEdit(offset=(0.02, 0.0, 0.0))}), state)
    assert other.scene.triangles is loaded.scene.triangles


def test_an_edited_scene_shares_geometry_and_has_lights_of_its_own(cpu: str) -> None:
    loaded = build(SceneRef("box", "cornell-box"), load_scene("cornell-box"), wp.get_device(cpu))
    off = SceneEdits(lights={"light": LightEdit(on=False)})
    state = edit(loaded, off)
    assert (state.ref, state.edits, loaded.edits) == (loaded.ref, off, NO_EDITS)
    assert state.device_scene.data.vertices is loaded.device_scene.data.vertices
    assert state.light_sets.table is not loaded.light_sets.table
    emitted = [it.device_scene.data.materials.numpy()["emission"].max() for it in (state, loaded)]
    assert emitted[0] == 0.0 < emitted[1]


def test_what_a_scene_has_is_looked_for_once(cpu: str) -> None:
    loaded = build(SceneRef("box", "cornell-box"), load_scene("cornell-box"), wp.get_device(cpu))
    assert loaded.features(lambertian=False) == scene_features(loaded.scene, lambertian=False, constants=False)
    assert loaded.features(lambertian=False) is loaded.features(lambertian=False)
