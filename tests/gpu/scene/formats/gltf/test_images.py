import base64
import io
import sys

import pytest
from gltf_file import GltfFile, image, material_of
from ktx2_file import ktx2, uastc_block
from PIL import Image

from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Wrap


def test_samplers(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf), sampler=gltf.add("samplers", wrapS=33071, wrapT=33648, magFilter=9728))
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    (texture,) = gltf.load().textures
    assert (texture.wrap_s, texture.wrap_t, texture.nearest) == (Wrap.CLAMP, Wrap.MIRROR, True)


def test_webp_goes_before_its_fallback(gltf: GltfFile) -> None:
    webp = image(gltf, "WEBP", (3, 1), lossless=True)
    gltf.add("textures", source=image(gltf), extensions={"EXT_texture_webp": {"source": webp}})
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    assert gltf.load().textures[0].pixels.shape == (1, 3, 4)


def basisu(gltf: GltfFile) -> None:
    """A texture that is KTX2 (8×4), with a fallback (2×1)."""
    packed = gltf.add("images", bufferView=gltf.view(ktx2([[uastc_block(1, 2, 3)] * 2], 8, 4)), mimeType="image/ktx2")
    gltf.add("textures", source=image(gltf), extensions={"KHR_texture_basisu": {"source": packed}})
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})


def test_ktx2_goes_before_its_fallback(gltf: GltfFile) -> None:
    pytest.importorskip("opengl_basisu")
    basisu(gltf)
    assert gltf.load().textures[0].pixels.shape == (4, 8, 4)


def test_without_the_extra_ktx2_gives_way_to_its_fallback(gltf: GltfFile, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    basisu(gltf)
    scene = gltf.load()
    assert scene.textures[0].pixels.shape == (1, 2, 4)
    assert "needs the extra ktx2: pip install lumenwalk[ktx2]; the image was left out" in scene.report.ignored[0]


def test_an_image_in_a_data_uri_and_one_in_a_file(gltf: GltfFile) -> None:
    file = io.BytesIO()
    Image.new("RGB", (4, 4)).save(file, "PNG")
    (gltf.folder / "an image.png").write_bytes(file.getvalue())
    for uri in ("data:image/png;base64," + base64.b64encode(file.getvalue()).decode(), "an%20image.png"):
        gltf.add("textures", source=gltf.add("images", uri=uri))
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}, normalTexture={"index": 1})
    assert [texture.pixels.shape for texture in gltf.load().textures] == [(4, 4, 4)] * 2


def test_a_broken_image(gltf: GltfFile) -> None:
    gltf.add("textures", source=gltf.add("images", bufferView=gltf.view(b"not an image"), mimeType="image/png"))
    gltf.add("textures", source=gltf.add("images", uri="data:image/png;base64,AAAA", name="wall"))
    green = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0, 1, 0, 1]}
    material = material_of(gltf, pbrMetallicRoughness=green, normalTexture={"index": 1})
    assert (material.base_color, material.base_color_slot, material.normal_slot) == ((0, 1, 0, 1), None, None)
    (sentence,) = gltf.load().report.ignored
    assert sentence.startswith("images[0]: not an image that can be read, which are PNG, JPEG")
    assert sentence.endswith("the image was left out (likewise images[1] 'wall')")


@pytest.mark.parametrize(
    ("uri", "says"),
    [
        ("textures/wall.png", "'textures/wall.png' does not exist beside the scene; the image was left out"),
        ("https://example.org/here.png", "is not fetched from the network"),
        ("/home/someone/wall.png", "does not exist beside the scene"),
        ("C:\\maps\\wall.png", "does not exist beside the scene"),
        (7, "must be a string; the image was left out"),
    ],
)
def test_an_image_that_is_not_there_is_left_out(gltf: GltfFile, uri: object, says: str) -> None:
    (gltf.folder / "here.png").write_bytes(b"")
    gltf.add("textures", source=gltf.add("images", uri=uri))
    assert material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}).base_color_slot is None
    assert says in gltf.load().report.ignored[0]


@pytest.mark.parametrize("uri", ["../wall.png", "outside/wall.png"])
def test_an_image_outside_the_folder_is_refused(gltf: GltfFile, uri: str) -> None:
    Image.new("RGB", (1, 1)).save(gltf.folder.parent / "wall.png")
    (gltf.folder / "outside").symlink_to(gltf.folder.parent)
    gltf.add("textures", source=gltf.add("images", uri=uri))
    with pytest.raises(SceneError, match=r"images\[0\]\.uri: .* outside the scene's folder"):
        material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})


def test_a_broken_webp_gives_way_to_its_fallback(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf), extensions={"EXT_texture_webp": {"source": 9}})
    assert material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}).base_color_slot is not None
    assert "images" not in gltf.load().report.ignored[0]


def test_a_texture_without_an_image_that_can_be_read_is_said(gltf: GltfFile) -> None:
    gltf.add("textures", extensions={"VENDOR_texture": {"source": 0}})
    assert material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}).base_color_slot is None
    assert "textures[0]: has no PNG, JPEG, WebP or KTX2 image and was ignored" in gltf.load().report.ignored


@pytest.mark.parametrize("key", ["wrapS", "wrapT", "magFilter"])
def test_what_is_odd_of_a_sampler_is_mended(gltf: GltfFile, key: str) -> None:
    gltf.add("textures", source=image(gltf), sampler=gltf.add("samplers", **{key: 10498}))
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    scene = gltf.load()
    texture = scene.textures[0]
    assert (texture.wrap_s, texture.wrap_t, texture.nearest) == (Wrap.REPEAT, Wrap.REPEAT, False)
    assert any(note.startswith(f"samplers[0].{key}: must be one of") for note in scene.report.notes)


def test_a_sampler_that_does_not_exist_is_left_out(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf), sampler=4)
    assert material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}).base_color_slot is not None
    assert (
        "textures[0].sampler: 4 does not exist, there are 0; the texture repeats, filtered" in gltf.load().report.notes
    )


def test_pixels_of_all_images_count_against_the_limit(gltf: GltfFile) -> None:
    for _ in range(2):
        gltf.add("textures", source=image(gltf, size=(2, 2)))
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}, normalTexture={"index": 1})
    assert len(gltf.load(SceneLimits(max_texture_pixels=8)).textures) == 2
    with pytest.raises(SceneError, match="max_texture_pixels"):
        gltf.load(SceneLimits(max_texture_pixels=7))
