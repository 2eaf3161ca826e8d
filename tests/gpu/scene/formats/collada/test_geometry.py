from pathlib import Path

import numpy as np
import pytest
from dae_file import BOUND, QUAD, dae, effect, geometry, source, use

from gpu.errors import SceneError
from gpu.scene.formats.collada import load_collada
from gpu.scene.formats.obj import load_obj
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import Scene

RED = effect("<lambert><diffuse><color>1 0 0 1</color></diffuse></lambert>")
GREEN = "0 1 0 1  0 1 0 1  0 1 0 1  0 1 0 0.5"
NAMES = {0: 'name="left" id="a"', 300: 'id="right"', 600: ""}
L_SHAPE = "0 0 0  200 0 0  200 100 0  100 100 0  100 200 0  0 200 0"


def load(folder: Path, content: bytes) -> Scene:
    (folder / "a.dae").write_bytes(content)
    return load_collada(folder / "a.dae")


def area(scene: Scene) -> float:
    """The area of all triangles, in square metres."""
    vectors = area_vectors(scene.vertices.astype(np.float64), scene.triangles)
    return float(np.linalg.norm(vectors, axis=1).sum() / 2.0 / scene.placement.scale**2)


def test_instances_in_centimetres_with_z_up(tmp_path: Path) -> None:
    nodes = [f"<node>{use(bound=BOUND)}</node>", f"<node><translate>300 0 50</translate>{use(bound=BOUND)}</node>"]
    scene = load(tmp_path, dae(nodes, libraries=RED))
    world = scene.vertices / scene.placement.scale + np.array(scene.placement.centre)
    np.testing.assert_allclose([world.min(axis=0), world.max(axis=0)], [[0, 0, -2], [4, 0.5, 0]], atol=1e-6)
    assert len(scene.triangles) == 4
    assert [material.name for material in scene.materials] == ["Red"]
    assert scene.report.ignored == ()


def test_objects_are_called_as_the_nodes_that_use_geometries_else_as_these(tmp_path: Path) -> None:
    named = [f"<node {name}><translate>{x} 0 0</translate>{use(bound=BOUND)}</node>" for x, name in NAMES.items()]
    scene = load(tmp_path, dae(named, libraries=RED))
    assert scene.objects == ("left", "right", "g")
    assert [float(low) for low in scene.object_boxes[0][:, 0]] == pytest.approx([0.0, 3.0, 6.0])


def test_a_concave_polygon_is_as_that_of_an_obj_file(tmp_path: Path) -> None:
    surface = "<polylist><vcount>6</vcount><p>3 4 5 0 1 2</p></polylist>"
    scene = load(tmp_path, dae(geometries=geometry(points=L_SHAPE, surface=surface)))
    (tmp_path / "a.obj").write_text(
        "".join(f"v {' '.join(row.split())}\n" for row in L_SHAPE.split("  ")) + "f 4 5 6 1 2 3\n"
    )
    obj = load_obj(tmp_path / "a.obj", DEFAULT_LIMITS)
    assert area(scene) == pytest.approx(3.0)
    np.testing.assert_array_equal(scene.triangles, obj.triangles)
    np.testing.assert_allclose(scene.vertices[:, [0, 2]] * (1, -1), obj.vertices[:, [0, 1]], atol=1e-6)


def test_a_mirrored_instance_keeps_its_front(tmp_path: Path) -> None:
    scene = load(tmp_path, dae([f"<node><scale>-1 1 1</scale>{use()}</node>"]))
    assert (scene.normals[:, 1] > 0.99).all()


def test_colours_of_vertices_are_as_on_a_display(tmp_path: Path) -> None:
    colors = source("c", GREEN.replace("1 0 ", "0.5 0 "), "RGBA")
    mesh = geometry(sources=colors, inputs='<input semantic="COLOR" source="#c" offset="0"/>')
    scene = load(tmp_path, dae(geometries=mesh))
    assert scene.colors is not None
    np.testing.assert_allclose(scene.colors[0], [0, 0.21404, 0, 1], atol=1e-4)


def test_a_skin_is_shown_in_its_bind_pose(tmp_path: Path) -> None:
    skin = (
        '<library_controllers><controller id="k"><skin source="#g"><bind_shape_matrix>1 0 0 50 0 1 0 0 0 0 1 0 0 0 0 1'
        '</bind_shape_matrix></skin></controller><controller id="o"><morph source="#k"/></controller>'
        "</library_controllers>"
    )
    for name in ("k", "o"):
        node = f'<node name="body"><instance_controller url="#{name}"/></node>'
        scene = load(tmp_path, dae([node], libraries=skin))
        assert len(scene.triangles) == 2
        assert scene.placement.centre[0] == pytest.approx(1.0)
        assert any(said.startswith("body: skinned and morphed") for said in scene.report.ignored)


def test_instances_count_before_they_are_made(tmp_path: Path) -> None:
    library = "".join(f'<node id="n{i}"><instance_node url="#n{i + 1}"/><instance_node url="#n{i + 1}"/></node>'
                      for i in range(40)) + f'<node id="n40">{use()}</node>'  # fmt: skip
    content = dae(['<node><instance_node url="#n0"/></node>'], libraries=f"<library_nodes>{library}</library_nodes>")
    (tmp_path / "a.dae").write_bytes(content)
    with pytest.raises(SceneError, match="max_triangles"):
        load_collada(tmp_path / "a.dae", SceneLimits(max_triangles=1000))


@pytest.mark.parametrize(
    ("points", "says"),
    [(QUAD.replace("200", "x"), "needs numbers"), (QUAD.replace("200", "NaN", 1), r"vertex 2: is not finite")],
)
def test_broken_positions_are_refused(tmp_path: Path, points: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        load(tmp_path, dae(geometries=geometry(points=points)))
