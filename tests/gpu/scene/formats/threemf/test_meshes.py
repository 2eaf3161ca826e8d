from pathlib import Path

import numpy as np
import pytest
from threemf_file import mesh, model, threemf

from gpu.errors import SceneError
from gpu.scene.formats.threemf import load_threemf
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.types import Scene

BASES = (
    '<basematerials id="5"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#00FF0080"/>'
    "</basematerials>"
)


def load(folder: Path, resources: str) -> Scene:
    (folder / "a.3mf").write_bytes(threemf(model(resources)))
    return load_threemf(folder / "a.3mf")


def test_triangles_look_outwards(tmp_path: Path) -> None:
    scene = load(tmp_path, f'<object id="1">{mesh()}</object>')
    corners = scene.vertices[scene.triangles].astype(np.float64)
    outwards = area_vectors(scene.vertices.astype(np.float64), scene.triangles)
    centre = corners.reshape(-1, 3).mean(axis=0)
    assert (np.einsum("tc,tc->t", outwards, corners.mean(axis=1) - centre) > 0).all()


def test_objects_keep_their_names(tmp_path: Path) -> None:
    bodies = f'<object id="1" name="hook">{mesh()}</object><object id="7">{mesh()}</object>'
    both = '<components><component objectid="1"/><component objectid="7"/></components>'
    (tmp_path / "a.3mf").write_bytes(threemf(model(f'{bodies}<object id="9">{both}</object>', '<item objectid="9"/>')))
    assert load_threemf(tmp_path / "a.3mf").objects == ("hook", "object 7")


def test_triangles_have_their_own_properties_or_those_of_the_object(tmp_path: Path) -> None:
    triangles = ('pid="5" p1="0"', "", 'pid="5" p1="9"', 'p1="0"')
    body = f'<object id="1" pid="5" pindex="1">{mesh(10.0, triangles)}</object>'
    scene = load(tmp_path, BASES + body)
    names = [scene.materials[number].name for number in scene.triangle_material]
    assert sorted(names) == ["a", "a", "b", "default"]
    assert "group 5: properties that do not exist: the triangles are grey" in scene.report.ignored


def test_paint_of_slicers_is_said(tmp_path: Path) -> None:
    painted = mesh(10.0, ('paint_color="4"', "", "", ""))
    scene = load(tmp_path, f'<object id="1" name="c">{painted}</object>')
    assert scene.report.ignored == ("object c: triangles painted in a slicer's own way are shown unpainted",)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('v1="0"', 'v1="4"', r"object 1: triangles\[0\]: index out of range"),
        ('v1="0"', 'v1="-1"', "index out of range"),
        ('v1="0"', "", "triangles: one has no v1"),
        ('x="10.0"', 'x="1,0"', "vertices: needs numbers"),
        ('x="10.0"', 'x=""', "vertices: needs numbers"),
        ('x="10.0"', 'x="inf"', "vertex 1: is not finite"),
    ],
)
def test_what_is_broken_is_refused(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        load(tmp_path, f'<object id="1">{mesh().replace(old, new)}</object>')
