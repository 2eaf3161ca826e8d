"""A round of clustering beside a plain one in NumPy."""

from itertools import pairwise

import numpy as np
import pytest
from scenes import results
from shadow_maps import COUNT, SIDE, again, clustered, folded_floor, maps_of, owners, seeds_of

from gpu.core.parameters import parameters
from gpu.lights.light_paths import Vpls
from gpu.lights.path_ends import surface_key_kernel
from gpu.scene.types import Doubles, Ints
from gpu.vpl.shadow_map_clusters import (
    SHADOW_MAP_CLUSTER_PARAMETERS,
    MapClusters,
    ShadowMapClusterParameters,
)


def unit(vectors: Doubles) -> Doubles:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30))


def unlike(
    chosen: ShadowMapClusterParameters, vpls: Vpls, position: Doubles, normal: Doubles, flux: Doubles
) -> Doubles:
    """μ of Eq. 1, (pixel, cluster)."""
    off = ((vpls.position.numpy()[:, None].astype(np.float64) - position[None]) ** 2).sum(axis=2)
    turned = 1.0 - vpls.normal.numpy() @ normal.T
    color = ((unit(vpls.flux.numpy())[:, None] - unit(flux)[None]) ** 2).sum(axis=2)
    return np.asarray(chosen.distance * off + chosen.normal * turned + chosen.flux * color)


def plain_round(chosen: ShadowMapClusterParameters, vpls: Vpls, seeds: Ints) -> Ints:
    """Of each pixel the seed of the cluster that it goes to, −1 where it is dark."""
    position, normal, flux = (of.numpy()[seeds].astype(np.float64) for of in (vpls.position, vpls.normal, vpls.flux))
    mu = unlike(chosen, vpls, position, normal, flux)
    return np.where(vpls.flux.numpy().sum(axis=1) > 0.0, seeds[mu.argmin(axis=1)], -1)


def seeds_in_order(vpls: Vpls, seeds: Ints) -> Ints:
    """Of neighbours in space side by side, as clusters are."""
    keys = results(surface_key_kernel, len(vpls.flux), [vpls.position, vpls.normal, vpls.flux], int)
    return seeds[np.argsort(keys[seeds], kind="stable")]


@pytest.mark.parametrize(
    ("maps", "weights"),
    [
        (1, {}),
        (3, {}),
        *((1, {name: factor * getattr(SHADOW_MAP_CLUSTER_PARAMETERS, name)})
          for name in ("distance", "normal", "flux") for factor in (0.5, 2.0)),
    ],
)  # fmt: skip
def test_pixels_go_to_the_most_like_cluster(maps: int, weights: dict[str, float]) -> None:
    atlas, chosen = maps_of(maps), parameters(ShadowMapClusterParameters, **weights)
    vpls = folded_floor(atlas, bumps=0.3)
    seeds = seeds_of(vpls)
    clustering, _ = clustered(atlas, vpls, seeds, chosen)
    owner = owners(clustering)
    found = np.where(owner >= 0, seeds_in_order(vpls, seeds)[owner], -1)
    expected = plain_round(chosen, vpls, seeds)
    assert (found == expected).mean() > 0.998  # but for ties in float32
    usual = plain_round(SHADOW_MAP_CLUSTER_PARAMETERS, vpls, seeds)
    assert (not weights) == bool((expected == usual).all())


def test_maps_that_are_worth_less_have_clusters_of_their_own() -> None:
    """However like they are: those of such a map without a seed go to none."""
    atlas = maps_of(3)
    atlas.worth.assign([1.0, 0.1, 0.2])
    vpls, map_of = folded_floor(atlas), np.repeat(np.arange(3), SIDE**2)
    lit = vpls.flux.numpy().sum(axis=1) > 0.0
    seeds = seeds_of(vpls)
    seeds = np.where(map_of[seeds] == 2, np.flatnonzero(lit)[0], seeds)
    clustering, _ = clustered(atlas, vpls, seeds)
    owner, medoids = owners(clustering), clustering.medoids.numpy()
    assert np.array_equal(owner >= 0, lit & (map_of < 2))
    assert np.array_equal(map_of[medoids[owner[owner >= 0]]], map_of[owner >= 0])


def test_the_usual_weights() -> None:
    """What the kernels' defaults are is told by no picture alone."""
    chosen = SHADOW_MAP_CLUSTER_PARAMETERS
    assert (chosen.distance, chosen.normal, chosen.flux) == (100.0, 10.0, 1.0)


def traits(clusters: MapClusters) -> Doubles:
    """Position, normal and color, (3, cluster, 3)."""
    return clusters.traits.numpy().astype(np.float64).reshape(-1, 3, 4)[:, :, :3].transpose(1, 0, 2)


def test_clusters_move_to_means_by_flux_and_medoids_are_members() -> None:
    atlas = maps_of()
    vpls = folded_floor(atlas)
    clustering, _ = clustered(atlas, vpls, seeds_of(vpls))
    clusters = clustering.clusters
    owner, flux = owners(clustering), vpls.flux.numpy().astype(np.float64)
    weight, found = flux.mean(axis=1), traits(clusters)
    normal, position = vpls.normal.numpy(), vpls.position.numpy()
    medoids = clustering.medoids.numpy()
    for cluster in range(COUNT):
        own = owner == cluster
        assert clusters.members.numpy()[cluster] == own.sum()
        if not own.any():
            assert medoids[cluster] == -1
            continue
        means = [np.average(of[own], axis=0, weights=weight[own]) for of in (position, normal)]
        assert np.allclose(found[0, cluster], means[0], atol=1e-5)
        assert np.allclose(found[1, cluster], unit(means[1]), atol=1e-5)
        assert np.allclose(found[2, cluster], unit(flux[own].sum(axis=0)), atol=1e-5)
        assert own[medoids[cluster]]


def test_members_that_follow_each_other_are_neighbours_on_a_surface() -> None:
    """Pixels beside each other need not be, of a light that has an extent."""
    atlas = maps_of()
    vpls = folded_floor(atlas)
    position = vpls.position.numpy()
    position[:, 0] += np.random.default_rng(3).uniform(-0.2, 0.2, len(position))
    vpls.position.assign(position)
    clustering, _ = clustered(atlas, vpls, seeds_of(vpls, count=8))
    items, starts = clustering.groups.items.numpy(), clustering.groups.starts.numpy()
    members = [items[begin:end] for begin, end in pairwise(starts)]

    def steps(orders: list[Ints]) -> float:
        return sum(float(np.linalg.norm(np.diff(position[order], axis=0), axis=1).sum()) for order in orders)

    assert steps(members) < 0.8 * steps([np.sort(own) for own in members])


def test_all_that_is_lit_has_a_cluster() -> None:
    atlas = maps_of(3)
    vpls = folded_floor(atlas)
    lit = vpls.flux.numpy().sum(axis=1) > 0.0
    # All begin in one corner of the first map.
    clustering, _ = clustered(atlas, vpls, np.flatnonzero(lit)[:COUNT])
    assert (owners(clustering) >= 0).tolist() == lit.tolist()


def test_seeds_stay_until_they_are_old_or_dark() -> None:
    """And all begin anew where they are to; ages are spread, so that few seeds change in a frame."""
    atlas = maps_of()
    vpls, frames = folded_floor(atlas), SHADOW_MAP_CLUSTER_PARAMETERS.frames
    first, others = seeds_of(vpls), seeds_of(vpls, seed=2)
    clustering, kept = clustered(atlas, vpls, first)
    before, numbers = owners(clustering), np.arange(COUNT)
    assert np.array_equal(kept.pixels.numpy(), first)
    again(clustering, kept, vpls, others, begins=False)
    old = numbers % frames == frames - 1
    assert np.array_equal(kept.pixels.numpy(), np.where(old, others, first))
    assert 0.8 < (owners(clustering) == before).mean() < 1.0
    flux = vpls.flux.numpy()
    flux[first[5]] = 0.0
    vpls.flux.assign(flux)
    again(clustering, kept, vpls, others, begins=False)
    old |= (numbers % frames == frames - 2) | (numbers == 5)
    assert np.array_equal(kept.pixels.numpy(), np.where(old, others, first))
    for _ in range(frames - 2):
        again(clustering, kept, vpls, others, begins=False)
    assert np.array_equal(kept.pixels.numpy(), others)
    again(clustering, kept, vpls, first, begins=True)
    assert np.array_equal(kept.pixels.numpy(), first)


def test_clusters_are_in_order_of_their_places() -> None:
    atlas = maps_of()
    vpls = folded_floor(atlas)
    seeds = np.random.default_rng(5).permutation(seeds_of(vpls))
    clustering, _ = clustered(atlas, vpls, seeds)
    apart = np.linalg.norm(np.diff(traits(clustering.clusters)[0], axis=0), axis=1)
    assert np.median(apart) < 0.5 * np.median(np.linalg.norm(np.diff(vpls.position.numpy()[seeds], axis=0), axis=1))


def test_in_the_dark_there_is_no_cluster() -> None:
    atlas = maps_of()
    vpls = folded_floor(atlas)
    vpls.flux.zero_()
    clustering, _ = clustered(atlas, vpls, np.full(COUNT, -1))
    assert (clustering.clusters.members.numpy() == 0).all()
    assert (clustering.medoids.numpy() == -1).all()
