from dataclasses import replace

import numpy as np
import pytest
from scenes import camera_of, grey, quad, resident_of

from gpu.device_scene.features import EVERYTHING
from gpu.gbuffer.gbuffer import GBuffer, allocate_gbuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import LIKELIER, chain_samples
from gpu.scene.camera import look_at
from gpu.scene.types import Material

SIZE, FRAMES = (8, 6), 64
CAMERA = look_at((0.0, 0.1, 1.5), (0.0, 0.0, 0.0), yfov_degrees=20.0)
PAPER = replace(grey(0.8), specular=0.0, diffuse_transmission=0.25, diffuse_transmission_color=(1.0, 0.5, 0.25))


def seen(material: Material, moment: int) -> GBuffer:
    sheet = quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])
    device_scene = resident_of([sheet], [material])
    gbuffer = allocate_gbuffer(SIZE[0] * SIZE[1], device_scene.device, EVERYTHING)
    samples, scene = chain_samples(device_scene.device, moment), device_scene.view(lambertian=False)
    trace_primary_rays(scene, camera_of(device_scene, CAMERA, SIZE), SIZE, gbuffer, samples)
    return gbuffer


def test_the_mean_of_frames_shows_what_both_sides_scatter() -> None:
    reflected, through, share = np.zeros(3), np.zeros(3), 0.0
    for moment in range(FRAMES):
        gbuffer = seen(PAPER, moment)
        behind = gbuffer.normal.numpy()[:, 2] < 0.0
        assert (gbuffer.normal.numpy() == gbuffer.geometric_normal.numpy()).all()
        assert ((gbuffer.normal.numpy() * gbuffer.to_camera.numpy()).sum(axis=1) > 0.0).all()
        assert not gbuffer.through.numpy().any()
        counted = gbuffer.albedo.numpy() * gbuffer.throughput.numpy()
        assert np.allclose(gbuffer.albedo.numpy(), gbuffer.diffuse.numpy())
        reflected += np.where(behind[:, None], 0.0, counted).mean(axis=0) / FRAMES
        through += np.where(behind[:, None], counted, 0.0).mean(axis=0) / FRAMES
        share += behind.mean() / FRAMES
    assert reflected == pytest.approx(np.full(3, 0.6), rel=0.02)
    assert through == pytest.approx([0.25, 0.125, 0.0625], rel=0.02)
    assert share == pytest.approx(0.3, abs=0.02)


def test_single_frames_see_both_sides_at_once() -> None:
    gbuffer = seen(PAPER, LIKELIER)
    assert np.allclose(gbuffer.through.numpy(), [0.25, 0.125, 0.0625])
    assert np.allclose(gbuffer.diffuse.numpy(), 0.6)
    assert np.allclose(gbuffer.albedo.numpy(), [0.85, 0.725, 0.6625])
    assert (gbuffer.normal.numpy()[:, 2] > 0.99).all()
    assert np.allclose(gbuffer.throughput.numpy(), 1.0)


def test_what_is_all_let_through_is_seen_from_behind_alone() -> None:
    shade = replace(PAPER, diffuse_transmission=1.0)
    for moment in range(4):
        gbuffer = seen(shade, moment)
        assert (gbuffer.normal.numpy()[:, 2] < -0.99).all()
        assert np.allclose(gbuffer.throughput.numpy(), 1.0)
