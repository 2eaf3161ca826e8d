from pathlib import Path

import numpy as np
import pytest
from threemf_file import mesh, model, threemf

from gpu.errors import SceneError
from gpu.scene.formats.threemf import load_threemf
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Scene

SOLID = f'<object id="1" name="part" type="model">{mesh()}</object>'


def load(folder: Path, content: bytes, limits: SceneLimits | None = None) -> Scene:
    (folder / "a.3mf").write_bytes(content)
    return load_threemf(folder / "a.3mf", limits or SceneLimits())


def bounds(scene: Scene) -> np.ndarray:
    world = scene.vertices / scene.placement.scale + np.array(scene.placement.centre)
    return np.array([world.min(axis=0), world.max(axis=0)])


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("", 1e-3), ('unit="inch"', 0.0254), ('unit="meter"', 1.0), ('unit="micron"', 1e-6), ('unit="mile"', 1e-3)],
)
def test_units_and_z_up(tmp_path: Path, unit: str, metres: float) -> None:
    scene = load(tmp_path, threemf(model(SOLID, '<item objectid="1" transform="1 0 0 0 1 0 0 0 2 0 0 0"/>', unit)))
    np.testing.assert_allclose(
        bounds(scene), np.array([[0, 0, -10], [10, 20, 0]]) * metres, rtol=1e-5, atol=1e-6 * metres
    )
    assert any("not known" in said for said in scene.report.ignored) == ("mile" in unit)


def test_components_within_components(tmp_path: Path) -> None:
    part = '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 {} 0 0"/>'
    pair = f'<object id="2"><components>{part.format(0)}{part.format(20)}</components></object>'
    both = '<item objectid="2"/><item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 100 0"/>'
    scene = load(tmp_path, threemf(model(SOLID + pair, both)))
    assert len(scene.triangles) == 16
    np.testing.assert_allclose(bounds(scene), [[-0.01, 0, -0.13], [0.03, 0.01, 0]], atol=1e-7)


def test_objects_of_other_files_with_the_same_ids(tmp_path: Path) -> None:
    """As slicers write them: an id counts within its file, and a file may have several objects."""
    inner = {
        f"3D/Objects/o{n}.model": model(
            f'<object id="1">{mesh(10.0 * n)}</object><object id="7">{mesh(90.0)}</object>', ""
        )
        for n in (1, 2)
    }
    parts = "".join(f'<component p:path="/3D/objects/o{n}.model" objectid="1"/>' for n in (1, 2))
    scene = load(tmp_path, threemf(model(f'<object id="1"><components>{parts}</components></object>'), inner))
    assert len(scene.triangles) == 8
    np.testing.assert_allclose(bounds(scene), [[0, 0, -0.02], [0.02, 0.02, 0]], atol=1e-7)


def test_what_is_not_shown_is_said(tmp_path: Path) -> None:
    lattice = SOLID.replace("</mesh>", "<b:beamlattice xmlns:b='urn:b'/></mesh>")
    support = f'<object id="2" type="support">{mesh()}</object>'
    build = '<item objectid="1"/><item objectid="2"/><item objectid="3"/>'
    scene = load(tmp_path, threemf(model(lattice + support, build)))
    assert len(scene.triangles) == 4
    assert scene.report.ignored == (
        "3D/start.model: beam lattices are not shown (1)",
        "object 2: supports are not shown",
        "'3': a resource that the file refers to is not in it",
    )


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", r"not a \.3mf file that can be unpacked"),
        (threemf("<model"), "start.model: not XML that can be read"),
        (threemf("<a/>"), "not a 3D model: its root is 'a'"),
        (threemf('<!DOCTYPE a [<!ENTITY b "c">]><model>&b;</model>'), "declares a document type"),
        (threemf(model(SOLID))[:-30], "unpacked"),
        (threemf(model(SOLID, "")), "no triangles"),
        (threemf(model(SOLID, '<item objectid="1" transform="1 2"/>')), "item: its transform is not 12 numbers"),
        (threemf(model(SOLID, f'<item objectid="1" transform="{"NaN " * 12}"/>')), "item: its transform is not finite"),
        (threemf(model('<object id="1"><components><component objectid="1"/></components></object>')),
         "object 1: it contains itself"),
    ],
)  # fmt: skip
def test_what_is_broken_is_refused(tmp_path: Path, content: bytes, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        load(tmp_path, content)


def test_limits_count_what_is_unpacked_and_instances(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="bytes unpacked"):
        load(tmp_path, threemf(model(SOLID) + " " * 100_000), SceneLimits(max_file_bytes=50_000))
    doubling = "".join(
        f'<object id="{n}"><components>{f"<component objectid={chr(34)}{n - 1}{chr(34)}/>" * 2}</components></object>'
        for n in range(2, 50)
    )
    with pytest.raises(SceneError, match="max_triangles"):
        load(tmp_path, threemf(model(SOLID + doubling, '<item objectid="49"/>')), SceneLimits(max_triangles=1000))
