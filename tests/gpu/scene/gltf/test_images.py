import base64
import io

import pytest
from gltf_file import GltfFile, image, material_of
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
    with pytest.raises(SceneError, match=r"images\[0\]: not an image"):
        material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})


def test_a_texture_without_an_image_that_can_be_read_is_said(gltf: GltfFile) -> None:
    gltf.add("textures", extensions={"KHR_texture_basisu": {"source": 0}})
    assert material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}).base_color_slot is None
    assert gltf.load().report.ignored == ("textures[0] has no PNG, JPEG or WebP image and was ignored",)


@pytest.mark.parametrize("key", ["wrapS", "wrapT"])
def test_an_unknown_wrap_mode_is_refused(gltf: GltfFile, key: str) -> None:
    gltf.add("textures", source=image(gltf), sampler=gltf.add("samplers", **{key: 10498}))
    with pytest.raises(SceneError, match=rf"samplers\[0\]\.{key}: 10498 is not a wrap mode"):
        material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})


def test_pixels_of_all_images_count_against_the_limit(gltf: GltfFile) -> None:
    for _ in range(2):
        gltf.add("textures", source=image(gltf, size=(2, 2)))
    material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}, normalTexture={"index": 1})
    assert len(gltf.load(SceneLimits(max_texture_pixels=8)).textures) == 2
    with pytest.raises(SceneError, match="max_texture_pixels"):
        gltf.load(SceneLimits(max_texture_pixels=7))
