import numpy as np
import pytest
from usd_file import SQUARE, UsdFile, facing, world

from gpu.errors import SceneError
from gpu.scene.formats.usd import load_usd
from gpu.scene.limits import SceneLimits

pytest.importorskip("pxr")
from pxr import UsdGeom, UsdShade

ARROW = ((0, 0, 0), (2, 0, 0), (1, 0.5, 0), (2, 2, 0))  # concave at its third corner


def area(scene: object) -> float:
    return float(np.linalg.norm(facing(scene), axis=1).sum() / 2.0)


def test_polygons_become_triangles(usd: UsdFile) -> None:
    usd.mesh("/Mesh", [*SQUARE, (2, 0, 0)], [4, 3], [0, 1, 2, 3, 1, 4, 2])
    scene = usd.load()
    assert area(scene) == pytest.approx(1.5)
    assert (facing(scene)[:, 2] > 0.0).all()


def test_concave_polygons(usd: UsdFile) -> None:
    usd.mesh("/Mesh", ARROW)
    scene = usd.load()
    assert area(scene) == pytest.approx(1.0)
    assert (facing(scene)[:, 2] > 0.0).all()


def test_left_handed_meshes_face_the_other_way(usd: UsdFile) -> None:
    usd.mesh().CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    assert (facing(usd.load())[:, 2] < 0.0).all()


def test_holes_are_left_open(usd: UsdFile) -> None:
    mesh = usd.mesh("/Mesh", [*SQUARE, (2, 0, 0)], [4, 3], [0, 1, 2, 3, 1, 4, 2])
    mesh.CreateHoleIndicesAttr([0])
    assert area(usd.load()) == pytest.approx(0.5)


def test_subdivision_surfaces_are_cages(usd: UsdFile) -> None:
    usd.mesh().CreateSubdivisionSchemeAttr(UsdGeom.Tokens.catmullClark)
    assert "/Mesh: subdivision surfaces are shown as their cages" in usd.load().report.ignored


@pytest.mark.parametrize("primvar", [False, True])
def test_normals(usd: UsdFile, primvar: bool) -> None:
    mesh = usd.mesh()
    mesh.CreateNormalsAttr([(0, 1, 0) if primvar else (1, 0, 1)] * 4)
    if primvar:
        usd.primvar(mesh, "normals", "Normal3fArray", "faceVarying", [(1, 0, 1)] * 4)
    assert np.allclose(usd.load().normals, (np.sqrt(0.5), 0, np.sqrt(0.5)))


def test_vertices_are_shared_where_all_their_values_are(usd: UsdFile) -> None:
    mesh = usd.mesh("/Mesh", [*SQUARE, (2, 0, 0)], [4, 3], [0, 1, 2, 3, 1, 4, 2])
    mesh.CreateNormalsAttr([(0, 0, 1)] * 5)
    assert len(usd.load().vertices) == 5


def test_double_sided_is_the_meshs_own(usd: UsdFile) -> None:
    mesh, other = usd.mesh(), usd.mesh("/Other")
    mesh.CreateDoubleSidedAttr(True)
    material = usd.material(mesh)
    UsdShade.MaterialBindingAPI.Apply(other.GetPrim()).Bind(material)
    scene = usd.load()
    assert [material.double_sided for material in scene.materials] == [True, False]
    assert [material.name for material in scene.materials] == ["Material", "Material"]


def test_subsets_have_materials_of_their_own(usd: UsdFile) -> None:
    mesh = usd.mesh("/Mesh", [*SQUARE, (2, 0, 0)], [4, 3], [0, 1, 2, 3, 1, 4, 2])
    usd.material(mesh, "/Rest")
    subset = UsdShade.MaterialBindingAPI(mesh).CreateMaterialBindSubset("part", [1])
    usd.material(subset, "/Part")
    scene = usd.load()
    areas = np.linalg.norm(facing(scene), axis=1) / 2.0
    by_name = {m.name: areas[scene.triangle_material == n].sum() for n, m in enumerate(scene.materials)}
    assert by_name == pytest.approx({"Part": 0.5, "Rest": 1.0})


def test_texture_coordinates_count_from_the_top(usd: UsdFile) -> None:
    mesh = usd.mesh()
    usd.primvar(mesh, "map", "TexCoord2fArray", "faceVarying", [(0, 0), (1, 0), (1, 1), (0, 1)])
    reader = usd.shader("/Reader", "UsdPrimvarReader_float2", varname="map")
    usd.image("a.png", [[(255, 0, 0)]])
    usd.material(mesh, diffuseColor=(usd.texture("/T", "a.png", st=(reader, "result")), "rgb"))
    scene = usd.load()
    places, uvs = world(scene).reshape(-1, 3), scene.uvs[0][scene.triangles].reshape(-1, 2)
    by_place = {tuple(np.rint(place).astype(int)): tuple(uv) for place, uv in zip(places, uvs, strict=True)}
    assert by_place == {(0, 0, 0): (0, 1), (1, 0, 0): (1, 1), (1, 1, 0): (1, 0), (0, 1, 0): (0, 0)}


def test_missing_texture_coordinates_are_said(usd: UsdFile) -> None:
    mesh = usd.mesh()
    usd.image("a.png", [[(255, 0, 0)]])
    usd.material(mesh, diffuseColor=(usd.texture("/T", "a.png"), "rgb"))
    scene = usd.load()
    assert "/Mesh: a mesh has no texture coordinates for its textures; (0, 0) was used" in scene.report.ignored
    assert not scene.uvs.any()


@pytest.mark.parametrize(
    ("name", "value", "field"),
    [
        ("FaceVertexIndices", [0, 1, 2, 9], "faceVertexIndices"),
        ("FaceVertexIndices", [0, 1, 2, -1], "faceVertexIndices"),
        ("FaceVertexCounts", [3], "faceVertexCounts"),
        ("FaceVertexCounts", [5, -1], "faceVertexCounts"),
        ("Points", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (np.inf, 0, 0)], "points"),
    ],
)
def test_broken_meshes_are_refused(usd: UsdFile, name: str, value: list, field: str) -> None:
    getattr(usd.mesh(), f"Get{name}Attr")().Set(value)
    with pytest.raises(SceneError, match=rf"/Mesh\.{field}"):
        usd.load()


def test_triangles_of_all_instances_are_counted(usd: UsdFile) -> None:
    usd.mesh()
    usd.mesh("/Other")
    with pytest.raises(SceneError, match="max_triangles"):
        load_usd(usd.write(), SceneLimits(max_triangles=3))
