import sys

import pytest
from gltf_file import GltfFile

from gpu.errors import SceneError


def test_a_required_extension_that_is_not_supported_is_refused_by_name(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.json["extensionsRequired"] = ["KHR_materials_unlit", "VENDOR_b", "VENDOR_a"]
    with pytest.raises(SceneError, match="needs VENDOR_a, VENDOR_b, which is not supported"):
        gltf.load()


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [
        ("KHR_texture_basisu", "opengl_basisu", "ktx2"),
        ("EXT_meshopt_compression", "meshopt", "meshopt"),
        ("KHR_meshopt_compression", "meshopt", "meshopt"),
    ],
)
def test_a_required_extension_whose_library_is_missing_is_refused_by_the_extra(
    gltf: GltfFile, name: str, module: str, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    gltf.mesh_node()
    gltf.json["extensionsUsed"] = [name]
    assert gltf.load().report.ignored == ()
    gltf.json["extensionsRequired"] = [name]
    with pytest.raises(SceneError, match=rf"needs the extra {extra}: pip install lumenwalk\[{extra}\]"):
        gltf.load()


def test_one_that_only_describes_may_be_required(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.json["extensionsRequired"] = ["KHR_xmp"]
    assert gltf.load().report.ignored == ("extension KHR_xmp is not supported and was ignored",)


@pytest.mark.parametrize("names", [5, [None, "KHR_materials_unlit"], {}])
def test_names_that_are_none_do_not_matter(gltf: GltfFile, names: object) -> None:
    gltf.mesh_node()
    gltf.json["extensionsRequired"] = names
    assert len(gltf.load().triangles) == 1


def test_a_used_extension_that_is_not_supported_is_said_once(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.json["extensionsUsed"] = ["KHR_xmp", "KHR_materials_unlit", "KHR_xmp"]
    assert gltf.load().report.ignored == ("extension KHR_xmp is not supported and was ignored",)
