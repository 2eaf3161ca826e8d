from dataclasses import dataclass, replace

import pytest
import warp as wp
from pydantic import ValidationError

from gpu.device_scene.features import EVERYTHING
from gpu.sample_counts import ON_CPU, ON_CUDA, PATHS, SampleCounts, bounces_of, sample_counts_of, usual_counts
from gpu.settings import Method, Quality, RenderSettings


def test_open_counts_are_chosen_for_the_device_and_given_ones_kept() -> None:
    cpu = wp.get_device("cpu")
    assert sample_counts_of(RenderSettings(), cpu) == ON_CPU
    sample_counts = sample_counts_of(RenderSettings(vpls=77, samples=3), cpu)
    assert (sample_counts.vpls, sample_counts.samples, sample_counts.sp_clusters) == (77, 3, ON_CPU.sp_clusters)
    assert sample_counts_of(RenderSettings(method=Method.PATH), cpu).samples == PATHS


@pytest.mark.parametrize(
    ("quality", "cuda", "counts"),
    [
        (Quality.DRAFT, True, SampleCounts(2048, 24_576, 512, 65_536, 64, 32_768, 2, 64, 64)),
        (Quality.DRAFT, False, SampleCounts(384, 2048, 96, 4096, 16, 4096, 1, 2, 64)),
        (Quality.BALANCED, True, ON_CUDA),
        (Quality.BEST, True, SampleCounts(16_384, 196_608, 4096, 524_288, 512, 262_144, 2, 2048, 256)),
        (Quality.BEST, False, SampleCounts(3072, 16_384, 768, 32_768, 128, 32_768, 1, 64, 128)),
    ],
)
def test_a_quality_has_more_or_less_of_what_is_left_open(quality: Quality, cuda: bool, counts: SampleCounts) -> None:
    assert usual_counts(quality, cuda=cuda) == counts


@pytest.mark.parametrize(("quality", "factor"), [(Quality.DRAFT, 0.25), (Quality.BALANCED, 1.0), (Quality.BEST, 2.0)])
def test_paths_are_of_a_quality_and_light_samples_are_not(quality: Quality, factor: float) -> None:
    cpu = wp.get_device("cpu")
    paths, light = (RenderSettings(method=method, quality=quality) for method in (Method.PATH, Method.FUZZY_VPL))
    assert sample_counts_of(paths, cpu).samples == factor * PATHS
    assert sample_counts_of(paths.model_copy(update={"samples": 7}), cpu).samples == 7
    assert sample_counts_of(light, cpu).samples == ON_CPU.samples


def test_what_the_user_counts_is_of_no_quality() -> None:
    counts = sample_counts_of(RenderSettings(quality=Quality.DRAFT, vpls=77, frames=9), wp.get_device("cpu"))
    assert (counts.vpls, counts.frames, counts.sp_clusters) == (77, 9, ON_CPU.sp_clusters // 4)


@pytest.mark.parametrize(
    ("shines", "given", "bounces"),
    [((), None, 4), (("gloss",), None, 6), (("frosted",), None, 6), (("specular",), None, 6), (("gloss",), 3, 3)],
)
def test_scenes_that_shine_have_more_bounces_unless_told(
    shines: tuple[str, ...], given: int | None, bounces: int
) -> None:
    has = replace(EVERYTHING, gloss=False, frosted=False, specular=False)
    has = replace(has, **dict.fromkeys(shines, True))
    assert bounces_of(RenderSettings(bounces=given), has) == bounces


@pytest.mark.parametrize("wrong", [{"vpls": 0}, {"fuzziness": 9}, {"exposure": -1.0}, {"unknown": 1}, {"method": "x"}])
def test_settings_out_of_range_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError, match=next(iter(wrong))):
        RenderSettings(**wrong)


@pytest.mark.parametrize(
    ("settings", "pixels", "clusters"),
    [
        (RenderSettings(), 320 * 180, 2057),
        (RenderSettings(), 1280 * 720, 8192),
        (RenderSettings(), 9, 1),
        (RenderSettings(sp_clusters=4096), 320 * 180, 4096),
        (RenderSettings(method=Method.PHOTON_GATHER), 320 * 180, 8192),
    ],
)
def test_small_pictures_have_fewer_clusters_on_a_gpu(settings: RenderSettings, pixels: int, clusters: int) -> None:
    @dataclass
    class Gpu:
        is_cuda: bool = True

    assert sample_counts_of(settings, Gpu(), pixels).sp_clusters == clusters
    assert sample_counts_of(RenderSettings(), wp.get_device("cpu"), pixels) == ON_CPU
