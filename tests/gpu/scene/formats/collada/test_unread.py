from pathlib import Path

from dae_file import dae, geometry

from gpu.scene.formats.collada import load_collada


def test_what_is_not_shown_is_counted(tmp_path: Path) -> None:
    libraries = (
        "<library_animations><animation/><animation/></library_animations>"
        "<library_physics_scenes><physics_scene/></library_physics_scenes>"
        '<library_visual_scenes><visual_scene id="other"/></library_visual_scenes>'
    )
    lines = geometry(surface="<polylist><vcount>4</vcount><p>0 1 2 3</p></polylist><lines/>", material="")
    (tmp_path / "a.dae").write_bytes(dae(geometries=lines + "<geometry><spline/></geometry>", libraries=libraries))
    assert set(load_collada(tmp_path / "a.dae").report.ignored) == {
        "animations are not played; the scene is shown without them (2)",
        "physics scenes are not used (1)",
        "geometries of kind spline are not shown (1)",
        "groups of lines are not shown (1)",
        "visual scenes other than the shown one were left out (1)",
    }
