"""The profile as Little CMS reads it, which knows nothing of ours."""

import io

import numpy as np
import pytest
from PIL import Image, ImageCms

from server.srgb_profile import SRGB_PROFILE


@pytest.fixture
def profile() -> ImageCms.ImageCmsProfile:
    return ImageCms.ImageCmsProfile(io.BytesIO(SRGB_PROFILE))


def test_it_is_a_small_display_profile_of_rgb(profile: ImageCms.ImageCmsProfile) -> None:
    assert len(SRGB_PROFILE) < 512
    assert int.from_bytes(SRGB_PROFILE[:4], "big") == len(SRGB_PROFILE)
    core = profile.profile
    assert (core.device_class, core.xcolor_space.strip(), core.connection_space.strip()) == ("mntr", "RGB", "XYZ")
    assert core.profile_description == "sRGB"
    assert core.red_primary is not None
    assert core.red_primary[1][:2] == pytest.approx((0.64, 0.33), abs=0.02)


def test_its_colours_are_those_of_little_cms(profile: ImageCms.ImageCmsProfile) -> None:
    colours = np.random.default_rng(3).integers(0, 256, (40, 40, 3), np.uint8)
    colours[0, :, :] = np.linspace(0, 255, 40)[:, None]
    known = ImageCms.createProfile("sRGB")
    there = ImageCms.profileToProfile(Image.fromarray(colours), profile, known)
    assert there is not None
    assert np.abs(np.asarray(there).astype(int) - colours).max() <= 1
