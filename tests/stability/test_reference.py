"""Path tracing against pictures that Mitsuba 3 made, pixel by pixel, with the test that Mitsuba's own renders take.

The pictures are of Lambertian surfaces, and of the files' own materials: metals, gloss, glass, alpha.

A z-test for each channel of each pixel at the significance level 0.01 of the whole picture (Šidák's correction), which
99.75 % of them have to pass (mitsuba3, src/render/tests/test_renders.py).
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from scipy import ndimage, stats

from gpu.core.device import CORES
from gpu.core.image_size import image_size
from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.direct.path_tracing import PathSamples, path_kernel
from gpu.gbuffer.camera_rays import CameraData, camera_data
from gpu.lights.build import build_light_table
from gpu.scene.load import load_scene
from gpu.scene.types import Doubles, Integers
from gpu.settings import Component

SIGNIFICANCE, SHARE = 0.01, 0.9975
# Mitsuba's floor under the variance of a sample, where too few of them met what is rare.
LEAST_VARIANCE = 1e-4
# Pictures with seeds of their own, for the variance.
SEEDS = 16
# Folders of references, and indirect bounces of their paths, by whether surfaces are Lambertian.
FOLDERS = {True: ("references", 4), False: ("references-gltf", 6)}
SCENES = ["conference", "cornell-box", "living-room", "sponza", "staircase", "veach-bidir"]
# What cannot be compared: some of the reference's rays leap over the second side of the living-room's blinds, which are
# 0.4 mm thick, and all of the light tells that less than direct light alone; veach-bidir's caustics are of so few paths
# that not even 8192 a pixel tell their mean.
LEFT_OUT = {("living-room", Component.DIRECT, False), ("veach-bidir", Component.FULL, False)}
CASES = [
    (name, component, lambertian)
    for name, component, lambertian in product(SCENES, (Component.FULL, Component.DIRECT), (True, False))
    if (name, component, lambertian) not in LEFT_OUT
]
# How much of a picture is traced, as rows that are spread over it, and how many pixels share their variance.
ROWS, NEIGHBOURS = 4, 9


def rows_of(device_scene: DeviceScene, size: tuple[int, int], rows: Integers, paths: PathSamples,
            lambertian: bool) -> Doubles:  # fmt: skip
    """Some rows, (row, width, 3), of the picture of the scene's camera in the reference's size."""
    width, height = size
    mean = wp.zeros(width * height, dtype=wp.vec3, device=device_scene.device)
    scene, table = device_scene.view(lambertian=lambertian), build_light_table(device_scene)
    camera = wp.array([camera_data(device_scene.scene.cameras[0], device_scene.scene.placement, width / height)],
                      dtype=CameraData, device=device_scene.device)  # fmt: skip
    inputs = [scene, table, camera, image_size((width, height)), paths, mean]
    kernel = path_kernel(device_scene.features(lambertian=lambertian))

    def trace(row: int) -> None:
        wp.launch(kernel, dim=width, inputs=[row * width, *inputs], device=device_scene.device)

    kernel.module.load(device_scene.device, block_dim=256 if device_scene.device.is_cuda else 1)
    with ThreadPoolExecutor(1 if device_scene.device.is_cuda else CORES) as pool:
        list(pool.map(trace, rows.tolist()))
    return np.asarray(mean.numpy(), np.float64).reshape(height, width, 3)[rows]


def passing_share(pictures: Doubles, samples: int, reference: Doubles, reference_samples: int) -> float:
    """The share of the channels of pixels where `pictures` (seed, row, width, 3) may have the mean `reference`.

    samples, reference_samples: a pixel of each picture, and of the reference.
    """
    # Of a few samples, many a pixel has met none of what is rare; its neighbours tell how noisy it is.
    variance = samples * ndimage.uniform_filter(pictures.var(axis=0, ddof=1), (0, NEIGHBOURS, 0))
    variance = np.maximum(variance, LEAST_VARIANCE) * (1.0 / (SEEDS * samples) + 1.0 / reference_samples)
    rounding = (reference * 2.0**-11) ** 2 / 3.0  # the reference is float16
    z = (pictures.mean(axis=0) - reference) / np.sqrt(variance + rounding)
    accepted = 2.0 * stats.norm.sf(np.abs(z)) > 1.0 - (1.0 - SIGNIFICANCE) ** (3.0 / reference.size)
    return float(accepted.mean())


@pytest.mark.parametrize(("name", "component", "lambertian"), CASES)
def test_pixels_agree_with_the_reference(
    shared: Path, device: str, name: str, component: Component, lambertian: bool
) -> None:
    folder, bounces = FOLDERS[lambertian]
    with np.load(shared / folder / f"{name}.npz") as file:
        reference, reference_samples = file[component.value].astype(np.float64), int(file["spp"])
    height, width = reference.shape[:2]
    rows = np.arange(height // (2 * ROWS), height, height // ROWS)
    # Few, so that their noise exceeds the reference's, of which only the mean is known; more where nothing else helps.
    samples = 16 if (name, component) == ("veach-bidir", Component.FULL) else 4
    device_scene = scene_on(shared / "scenes" / f"{name}.glb", device)
    taken = [
        parameters(PathSamples, count=samples, bounces=bounces, indirect=component is Component.FULL, seed=seed)
        for seed in range(SEEDS)
    ]
    pictures = np.stack([rows_of(device_scene, (width, height), rows, paths, lambertian) for paths in taken])
    assert passing_share(pictures, samples, reference[rows], reference_samples) >= SHARE
    # As much noise as there is, a fifth too much light would be seen.
    assert passing_share(1.2 * pictures, samples, reference[rows], reference_samples) < SHARE


@lru_cache(maxsize=1)
def scene_on(path: Path, device: str) -> DeviceScene:
    """The scene in a file, loaded once, with geometric normals, as the references have them."""
    scene = load_scene(str(path))
    return DeviceScene(replace(scene, normals=np.zeros_like(scene.normals)), device)
