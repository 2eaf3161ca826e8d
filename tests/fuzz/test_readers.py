"""A short run of the fuzzer over each format, the same one each time, and what longer runs have found."""

import struct
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest

from tests.fuzz import corpus
from tests.fuzz.mutate import mutated
from tests.fuzz.readers import read
from tests.fuzz.seed import Seed
from tests.fuzz.seeds import seeds
from tests.fuzz.seeds_of_libraries import library_of

ROUNDS = 12
SEEDS = {seed.name: seed for seed in seeds()}
SIGNALLING = struct.pack("<I", 0x7F800001)  # a NaN that arithmetic complains of


@pytest.mark.parametrize("name", SEEDS)
def test_a_seed_is_a_scene_and_changed_ones_are_or_are_refused(name: str, tmp_path: Path) -> None:
    seed, dice = SEEDS[name], Random(0)
    assert read(tmp_path, seed)
    for _ in range(0 if library_of(name) else ROUNDS):  # a library may end this process
        content = mutated(dice, seed.content, seed.content, is_gltf=name.endswith(("glb", "gltf")))
        read(tmp_path, replace(seed, content=content))


def test_what_longer_runs_have_kept_is_read_or_refused(tmp_path: Path) -> None:
    kept = [seed for seed in corpus.read(SEEDS.values()) if not library_of(seed.name)]
    assert len(kept) > 50
    for seed in kept:
        read(tmp_path, seed)


@pytest.mark.parametrize("name", ["binary.stl", "binary.ply", "binary.off", "scene.glb"])
def test_any_four_bytes_may_be_a_number(name: str, tmp_path: Path) -> None:
    content = SEEDS[name].content
    packed = SIGNALLING if name != "binary.off" else SIGNALLING[::-1]
    start = {"binary.stl": 84, "binary.ply": content.index(b"end_header\n") + 11 if "ply" in name else 0}.get(
        name, 23 if "off" in name else len(content) - 200
    )
    for at in range(start, min(start + 60, len(content) - 4), 4):
        read(tmp_path, Seed(name, content[:at] + packed + content[at + 4 :]))


@pytest.mark.parametrize("far", [1e25, 1e30, 3e38])
def test_a_corner_may_be_farther_away_than_numbers_go(far: float, tmp_path: Path) -> None:
    facets = np.zeros(3, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    facets["corners"][:] = np.eye(3)
    facets["corners"][1] *= 1e-38
    for corners in (facets["corners"][0], facets["corners"][1]):
        corners[1] = far, -far, 0
        content = bytes(80) + struct.pack("<I", len(facets)) + facets.tobytes()
        read(tmp_path, Seed("far.stl", content))


@pytest.mark.parametrize("faces", [-1, 2**31 - 1])
def test_a_file_says_how_many_faces_it_has_and_gets_no_memory_for_it(faces: int, tmp_path: Path) -> None:
    content = SEEDS["binary.off"].content.replace(struct.pack(">3i", 3, 1, 0), struct.pack(">3i", 3, faces, 0))
    assert not read(tmp_path, Seed("many.off", content))


def test_the_same_dice_make_the_same_files() -> None:
    content = SEEDS["scene.gltf"].content
    made = [[mutated(dice, content, content, is_gltf=True) for _ in range(20)] for dice in (Random(3), Random(3))]
    assert made[0] == made[1]
    assert len(set(made[0])) > 15
