import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline, relative_error
from scenes import column, results, slats

from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.correction.brightness import MeanBrightness
from gpu.correction.outlier_shading import (
    RAYS,
    REFINEMENT_PARAMETERS,
    Refinement,
    RefinementParameters,
    most_visible,
    outlier_part_kernel,
    outlier_ray_kernel,
)
from gpu.correction.outliers import OutlierPoints
from gpu.correction.visibility_correction import Correction
from gpu.correction.vpl_sampling import VPL_SAMPLE_PARAMETERS
from gpu.gbuffer.shading_points import ListedPoints
from gpu.scene.types import Doubles
from gpu.vpl.group_sampling import PARTS, group_table, sum_parts
from gpu.vpl.shadow_rays import shadow_rays

SEEDS = 100


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    device_scene, camera, size = slats((48, 36))
    return Pipeline(device_scene, camera, size, sp_clusters=80)


UNBOUNDED = parameters(RefinementParameters, deviations=0.0)


def refine(
    fuzzy: Pipeline,
    points: ListedPoints,
    seeds: int = 1,
    cluster_visibility: float | None = None,
    by: RefinementParameters = REFINEMENT_PARAMETERS,
) -> Doubles:
    """Irradiance after refining `points` by each seed, (seed, pixel, 3); believed: before, all over."""
    view, irradiance = fuzzy.view, fuzzy.view.indirect.irradiance
    refinement = Refinement(points.capacity, fuzzy.lights.count, view.device, by)
    found = []
    for seed in range(seeds):
        fuzzy.shade()
        if cluster_visibility is not None:
            irradiance.fill_(cluster_visibility)
        view.seed.fill_(seed)
        refinement.run(view.scene, view.gbuffer, points, fuzzy.lights, view.seed, irradiance)
        found.append(fuzzy.irradiance())
    fuzzy.shade()
    return np.stack(found)


@pytest.mark.parametrize("vpls", [250, 1500])  # fewer groups than parts, and more
def test_rays_keep_the_expectation(fuzzy: Pipeline, vpls: int) -> None:
    # Every VPL a cluster of its own: then light of members and of clusters is the same.
    points = Pipeline(fuzzy.device_scene, fuzzy.camera, (12, 9), sp_clusters=30, vpls=vpls, vpl_clusters=4000)
    assert (points.lights.groups > PARTS) == (vpls == 1500)
    exact = points.exact()[points.pixels]
    found = refine(points, points.view.shading_points, SEEDS, 1e6, UNBOUNDED)[:, points.pixels]
    whole = found.sum(axis=1)
    error = whole.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    assert (np.abs(whole.mean(axis=0) - exact.sum(axis=0)) < 4.0 * error).all()
    assert (error < 0.02 * exact.sum(axis=0)).all()
    each = found.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    deviations = ((found.mean(axis=0) - exact) / np.maximum(each, 1e-3 * each.mean()))[..., 0]
    assert np.mean(deviations**2) < 1.5


def test_rays_to_members_of_clusters_come_near_the_light_of_all_members(fuzzy: Pipeline) -> None:
    exact = fuzzy.of_members()
    mean = refine(fuzzy, fuzzy.view.shading_points, 12, 1e6, UNBOUNDED).mean(axis=0)
    assert mean.mean() == pytest.approx(exact.mean(), rel=0.02)
    assert relative_error(mean, exact) < 0.3 * relative_error(fuzzy.irradiance(), exact)


def test_light_that_rays_bring_is_tinted(fuzzy: Pipeline) -> None:
    view, lights = fuzzy.view, fuzzy.lights

    def refined(tint: tuple[float, float, float]) -> Doubles:
        points = view.shading_points
        refinement = Refinement(points.capacity, lights.count, view.device, UNBOUNDED, tinted=True)
        refinement._rays.tint.fill_(tint)  # as if traced in a scene with part glass
        view.indirect.irradiance.fill_(1e6)
        refinement.run(view.scene, view.gbuffer, points, lights, view.seed, view.indirect.irradiance)
        return fuzzy.irradiance()[fuzzy.pixels]

    white, tinted = refined((1.0, 1.0, 1.0)), refined((2.0, 0.75, 0.25))
    assert white.mean() > 0.0
    assert tinted == pytest.approx(white * (2.0, 0.75, 0.25), rel=1e-4)


def test_rays_of_their_own_lower_the_error_of_the_worst_and_leave_the_others(fuzzy: Pipeline) -> None:
    many = Pipeline(fuzzy.device_scene, fuzzy.camera, fuzzy.size, sp_clusters=80, vpls=4000, vpl_clusters=800)
    view, before, exact = many.view, many.irradiance(), many.of_members()
    correction = Correction(view.pixels, view.device)
    many.correct(correction, 0)
    irradiance = view.indirect.irradiance
    none = wp.zeros(view.pixels, dtype=int, device=view.device)
    shared = view.smoothing.share(
        view.gbuffer, view.shading_points, irradiance, correction.own, none, nearer_on_detail=False
    )
    points = OutlierPoints(view.pixels, 400, view.device)
    mean = MeanBrightness(view.device)
    mean.find(view.gbuffer, view.shading_points, irradiance)
    points.find(view.shading_points, view.gbuffer, many.clustering.deficit, irradiance, correction.own, shared, mean)
    refined = points.pixels.numpy()[: points.count.numpy()[0]]
    assert len(refined) > 100
    smoothed = np.maximum(before + shared.numpy(), 0.0)
    irradiance.assign(smoothed.astype(np.float32))
    Refinement(points.capacity, many.lights.count, view.device).run(
        view.scene, view.gbuffer, points, many.lights, view.seed, irradiance
    )
    after = many.irradiance()
    # The mean of the whole picture is what dark means, so those that were refined are compared inside it.
    floor = 0.01 * exact.mean() ** 2
    error = [np.mean((x[refined] - exact[refined]) ** 2 / (exact[refined] ** 2 + floor)) for x in (smoothed, after)]
    assert error[1] < min(0.85 * error[0], 0.007)
    others = np.setdiff1d(np.arange(view.pixels), refined)
    assert np.allclose(after[others], smoothed[others])


def test_light_is_the_most_that_rays_leave_possible_if_that_is_less_than_was_believed(fuzzy: Pipeline) -> None:
    points, pixels = fuzzy.view.shading_points, fuzzy.pixels
    said = refine(fuzzy, points, 1, 1e6, UNBOUNDED)[0][pixels].mean(axis=1)
    most = refine(fuzzy, points, 1, 1e6)[0][pixels].mean(axis=1)
    assert (most < 1e5).all()
    assert (most > 0.999 * said).all()
    assert np.mean(most > 1.05 * said) > 0.5
    believed = float(np.median(most))
    after = refine(fuzzy, points, 1, believed)[0][pixels].mean(axis=1)
    assert after == pytest.approx(np.minimum(most, believed), rel=1e-3)


@wp.kernel
def most_visible_kernel(first: int, shares: wp.array[float], rays: float, deviations: float,
                        out: wp.array[float]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = most_visible(shares[index], rays, deviations)


def test_what_rays_leave_possible_is_wilsons_interval_of_one_deviation() -> None:
    """Its end is a share that finds what was found one deviation below itself."""
    shares = np.array([0.0, 0.1, 0.5, 1.0])
    inputs = [column(shares, float), 32.0, REFINEMENT_PARAMETERS.deviations]
    most = results(most_visible_kernel, 4, inputs, float)
    assert most - np.sqrt(most * (1.0 - most) / 32.0) == pytest.approx(shares, abs=1e-5)


def largest_share(fuzzy: Pipeline, by: RefinementParameters) -> float:
    """How much the ray of any SP counts that counts most, over all that its clusters' disks send."""
    view, lights, points = fuzzy.view, fuzzy.lights, fuzzy.view.shading_points
    table = group_table(lights.count, points.capacity, view.device)
    rays = shadow_rays(points.capacity, RAYS, view.device, side_by_side=True, control_variate=False)
    view.seed.fill_(0)
    launch(outlier_part_kernel, PARTS * points.capacity, [view.gbuffer, points.points, lights, table], view.device)
    sum_parts(table, points.capacity, points.count)
    inputs = [view.gbuffer, points.points, lights, table, view.seed, rays, VPL_SAMPLE_PARAMETERS, by]
    launch(outlier_ray_kernel, RAYS * points.capacity, inputs, view.device)
    return float(rays.share.numpy()[rays.vpl.numpy() >= 0].max())


def test_a_near_cluster_counts_at_most_so_many_times_as_much_as_its_disk(fuzzy: Pipeline) -> None:
    assert largest_share(fuzzy, REFINEMENT_PARAMETERS) == 32.0
    assert largest_share(fuzzy, parameters(RefinementParameters, most_whole=1e9)) > 100.0


def test_the_same_seed_gives_the_same_bits_and_another_other_rays(fuzzy: Pipeline) -> None:
    first, second = refine(fuzzy, fuzzy.view.shading_points, 2), refine(fuzzy, fuzzy.view.shading_points, 2)
    assert first.tobytes() == second.tobytes()
    assert (first[0] != first[1]).any()


def test_nobody_to_refine_changes_nothing(fuzzy: Pipeline) -> None:
    points = OutlierPoints(fuzzy.view.pixels, 10, fuzzy.view.device)
    points.count.zero_()
    assert np.array_equal(refine(fuzzy, points)[0], fuzzy.irradiance())
