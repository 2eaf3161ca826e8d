import pytest
from pydantic import BaseModel, ValidationError

from gpu.settings import EVERY_SKIP, Method, RenderSettings, Skips


def test_defaults_leave_counts_to_the_device() -> None:
    settings = RenderSettings()
    assert settings.method is Method.FUZZY_VPL
    assert settings.fuzziness == 6
    assert settings.bounces is None
    assert settings.sp_clusters is settings.vpls is settings.vpl_clusters is settings.samples is None


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("sp_clusters", [1, 262_144], [0, 262_145, 1.5]),
        ("vpls", [1, 4_194_304], [0, 4_194_305]),
        ("vpl_clusters", [1, 65_536], [0, 65_537]),
        ("fuzziness", [1, 8], [0, 9]),
        ("bounces", [1, 16], [0, 17]),
        ("samples", [1, 65_536], [0, 65_537]),
        ("target_ms", [0.1, 10_000.0, None], [0.0, -1.0, 10_001.0, float("nan")]),
        ("target_error", [1e-6, 1.0, None], [0.0, 1.1, float("nan")]),
        ("seed", [0, 2**31 - 1], [-1, 2**31]),
        ("exposure", [1e-6, 1e12, None], [0.0, -1.0, 1e13, float("nan"), float("inf")]),
        ("method", ["path", "exact-vpl"], ["raster"]),
        ("component", ["full", "direct", "indirect"], ["caustics"]),
        ("clustering", ["both", "sps", "vpls"], ["none"]),
        ("weighting", ["distance", "average"], ["gauss"]),
    ],
)
def test_limits_are_inclusive_and_enforced(name: str, good: list[object], bad: list[object]) -> None:
    for value in good:
        assert getattr(RenderSettings(**{name: value}), name) == value
    for value in bad:
        with pytest.raises(ValidationError, match=name):
            RenderSettings(**{name: value})


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize(
    ("name", "words"), [("exposure", "above 0 and at most 1e+12"), ("target_error", "of at least 1e-06 and at most 1")]
)
def test_what_is_not_finite_is_refused_with_the_range(name: str, words: str, value: float) -> None:
    with pytest.raises(ValidationError) as told:
        RenderSettings.model_validate({name: value})
    (problem,) = told.value.errors()
    assert (problem["loc"], problem["msg"]) == ((name,), f"must be a finite number {words}")


def test_unknown_fields_and_changes_are_refused() -> None:
    with pytest.raises(ValidationError, match="spclusters"):
        RenderSettings(spclusters=3)
    with pytest.raises(ValidationError, match="frozen"):
        RenderSettings().seed = 3


def test_settings_tell_settings_apart() -> None:
    assert len({RenderSettings(), RenderSettings(seed=0), RenderSettings(seed=1)}) == 2


@pytest.mark.parametrize("model", [RenderSettings, Skips])
def test_every_field_says_what_it_is(model: type[BaseModel]) -> None:
    assert all(field.description for field in model.model_fields.values())


def test_skips_are_all_on_and_each_can_be_off() -> None:
    assert all(EVERY_SKIP.model_dump().values())
    settings = RenderSettings.model_validate({"skip": {"shared_weak_rays": False}})
    assert settings.skip == Skips(shared_weak_rays=False)
    assert len({settings, RenderSettings()}) == 2
    with pytest.raises(ValidationError, match="strong_pairs"):
        RenderSettings.model_validate({"skip": {"strong_pairs": False}})


@pytest.mark.parametrize("method", ["photon-gather", "rsm-disks"])
@pytest.mark.parametrize("clustering", ["sps", "vpls"])
def test_methods_without_other_clusterings_refuse_them(method: str, clustering: str) -> None:
    with pytest.raises(ValidationError, match=f"clustering\n  must be both for {method}"):
        RenderSettings(method=method, clustering=clustering)


@pytest.mark.parametrize("target", [{"target_ms": 10.0}, {"target_error": 1e-3}])
@pytest.mark.parametrize(
    ("other", "needed"),
    [
        ({"method": "path"}, "needs method fuzzy-vpl"),
        ({"clustering": "sps"}, "needs clustering both"),
        ({"component": "direct"}, "needs component full or indirect"),
        ({"sp_clusters": 100}, "needs sp_clusters left out"),
        ({"vpl_clusters": 100, "sp_clusters": 9}, "needs sp_clusters left out and vpl_clusters left out"),
    ],
)
def test_a_target_needs_clusters_whose_counts_are_free(
    target: dict[str, float], other: dict[str, object], needed: str
) -> None:
    assert RenderSettings(**target, component="indirect", vpls=500)
    with pytest.raises(ValidationError, match=f"{next(iter(target))}\n  {needed}"):
        RenderSettings(**target, **other)


def test_two_targets_are_one_too_many() -> None:
    with pytest.raises(ValidationError, match="target_error\n  needs target_ms left out"):
        RenderSettings(target_ms=10.0, target_error=1e-3)


@pytest.mark.parametrize("side", [63, 65, 100, 513])
def test_sides_of_shadow_maps_are_powers_of_two(side: int) -> None:
    with pytest.raises(ValidationError):
        RenderSettings(shadow_map=side)


def test_a_side_that_warping_cannot_halve_is_told_which_ones_it_can() -> None:
    with pytest.raises(ValidationError, match="must be 64, 128, 256 or 512"):
        RenderSettings(shadow_map=96)
