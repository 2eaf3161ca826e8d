import numpy as np
import pytest
from pipeline import Pipeline, relative_error
from scenes import slats

from gpu.correct import Correction
from gpu.scene.types import Doubles
from gpu.shade import CHECKS, HIDDEN_WORDS

SEEDS = 400
SIZE = (16, 12)


def point_lights(fuzziness: int = 6) -> Pipeline:
    """Every VPL a cluster of its own: then light of members and of clusters is the same."""
    resident, camera, _ = slats()
    return Pipeline(resident, camera, SIZE, sp_clusters=30, fuzziness=fuzziness, vpls=250, vpl_clusters=1000)


def corrections(fuzzy: Pipeline, seeds: int) -> Doubles:
    """What the SPs' rays correct, by each seed, (seed, pixel, 3)."""
    view = fuzzy.view
    correction = Correction(view.pixels, view.device)
    found = []
    for seed in range(seeds):
        fuzzy.shade(seed)
        correction.trace(view.scene, view.gbuffer, view.shading_points, fuzzy.lights, seed, view.indirect)
        found.append(correction.own.numpy().astype(np.float64))
    fuzzy.shade()
    return np.stack(found)


@pytest.fixture(scope="module")
def clustered() -> Pipeline:
    resident, camera, _ = slats()
    return Pipeline(resident, camera, (24, 18), sp_clusters=60)


def variance_of(fuzzy: Pipeline) -> Doubles:
    """Of the brightness that the rays of each SP correct by its one seed, (sp,), from what they are drawn by."""
    amount, shares, seen = fuzzy.unhidden().mean(axis=2), fuzzy.shares(), fuzzy.seen()
    found = amount * (seen - shares) * (shares > 0.0)
    doubted = (amount * fuzzy.doubts() * (shares > 0.0)).sum(axis=1, keepdims=True)
    some = (doubted * found * (seen - shares) / fuzzy.doubts()).sum(axis=1) - found.sum(axis=1) ** 2
    hidden = amount * (shares == 0.0)
    found = hidden * seen
    other = hidden.sum(axis=1) * found.sum(axis=1) - found.sum(axis=1) ** 2
    # Some words of which nothing is seen stand for the others.
    words = np.arange(0, fuzzy.lights.count, 32)
    unseen = np.add.reduceat(shares, words, axis=1) == 0.0
    product = np.add.reduceat(hidden, words, axis=1) * np.add.reduceat(found, words, axis=1)
    other += (int(HIDDEN_WORDS) - 1) * (product * unseen).sum(axis=1)
    return np.maximum(some / (CHECKS - 1) + other, 0.0)


@pytest.mark.parametrize("beliefs", ["traced", "nonsense", "nothing", "everything"])
def test_the_mean_of_corrections_is_what_clusters_are_wrong_by(beliefs: str) -> None:
    fuzzy = point_lights()
    shape = (fuzzy.clustering.count, fuzzy.lights.count)
    if beliefs == "nonsense":
        fuzzy.believe(np.random.default_rng(0).integers(0, 2, shape))
    elif beliefs != "traced":
        fuzzy.believe(np.full(shape, int(beliefs == "everything")))
    wrong = (fuzzy.exact() - fuzzy.irradiance())[fuzzy.pixels].mean(axis=1)
    found = corrections(fuzzy, SEEDS)[:, fuzzy.pixels].mean(axis=2)
    off = found.mean(axis=0) - wrong
    error = np.sqrt(variance_of(fuzzy) / SEEDS)
    whole = found.sum(axis=1).std(ddof=1) / np.sqrt(SEEDS)
    # What is found is much more than noise, or nothing would be tested; by SPs, and by the whole picture.
    assert np.abs(wrong).sum() > 10.0 * whole
    assert abs(off.sum()) < 4.0 * whole
    exact = error <= 1e-6 * error.max()
    assert np.abs(off[exact]).max(initial=0.0) < 1e-3 * error.max()
    # The mean over SPs would be 1, but neighbours leave the same words out: of 4000 seeds, tenths gave 0.6 … 1.6.
    assert 0.4 < np.mean((off[~exact] / error[~exact]) ** 2) < 2.0


def test_where_clusters_tell_the_truth_nothing_is_corrected() -> None:
    fuzzy = point_lights(fuzziness=1)
    assert (corrections(fuzzy, 1) != 0.0).any()
    fuzzy.know_the_truth()
    assert (corrections(fuzzy, 3) == 0.0).all()


def test_pictures_of_vpl_clusters_come_near_those_of_all_their_members(clustered: Pipeline) -> None:
    exact, fuzzy = clustered.of_members(), clustered.irradiance()
    corrected = fuzzy + corrections(clustered, 100).mean(axis=0)
    assert relative_error(corrected, exact) < 0.1 * relative_error(fuzzy, exact)
    assert corrected.mean() == pytest.approx(exact.mean(), rel=0.02)


def test_a_correction_has_less_noise_than_the_light_it_corrects(clustered: Pipeline) -> None:
    noise = corrections(clustered, 100).std(axis=0)[clustered.pixels]
    blind = Pipeline(clustered.resident, clustered.camera, clustered.size, sp_clusters=60)
    blind.believe(np.zeros((blind.clustering.count, blind.lights.count)))
    assert (noise**2).mean() < 0.3 * (corrections(blind, 100).std(axis=0)[blind.pixels] ** 2).mean()


def test_the_same_seed_gives_the_same_bits_and_another_other_rays(clustered: Pipeline) -> None:
    first, second = corrections(clustered, 2), corrections(clustered, 2)
    assert first.tobytes() == second.tobytes()
    assert (first[0] != first[1]).any()
