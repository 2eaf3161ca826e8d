import numpy as np
import pytest
from scenes import box, grey, quad, resident_of, slats

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import Floats
from gpu.settings import Clustering, Component, Method, RenderSettings, Weighting

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
QUALITY = {"sp_clusters": 200, "vpls": 2000, "vpl_clusters": 100}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)])


def picture(device_scene: DeviceScene, **settings: object) -> Floats:
    """Linear radiance of a frame."""
    return Renderer(device_scene, SIZE, RenderSettings(**{**QUALITY, **settings})).render(CAMERA).radiance()


def relative_error(x: Floats, r: Floats) -> float:
    return float(np.mean((x - r) ** 2 / (r**2 + 0.01 * r.mean() ** 2)))


@pytest.mark.parametrize("clustering", list(Clustering))
@pytest.mark.parametrize(("fuzziness", "weighting"), [(1, Weighting.AVERAGE), (6, Weighting.DISTANCE), (8, "average")])
def test_every_choice_of_the_ablation_is_near_exact_vpl(
    room: DeviceScene, clustering: Clustering, fuzziness: int, weighting: Weighting
) -> None:
    exact = picture(room, method=Method.EXACT_VPL, component=Component.INDIRECT)
    choice = {"clustering": clustering, "fuzziness": fuzziness, "weighting": weighting}
    assert relative_error(picture(room, component=Component.INDIRECT, **choice), exact) < 0.03


@pytest.mark.parametrize("smooth", [False, True])
def test_rays_of_shading_points_lower_the_error_of_their_clusters(smooth: bool) -> None:
    device_scene, camera, size = slats()
    settings = RenderSettings(component=Component.INDIRECT, sp_clusters=80, vpls=4000, vpl_clusters=800,
                              near_field=False, smooth=smooth)  # fmt: skip
    reference = Renderer(device_scene, size, settings.model_copy(update={"method": Method.EXACT_VPL})).render(camera)
    exact = reference.radiance()
    errors = []
    for correct in (False, True):
        renderer = Renderer(device_scene, size, settings.model_copy(update={"correct": correct}))
        frame = renderer.render(camera)
        assert ("correct" in frame.stats.stage_ms, "refine" in frame.stats.stage_ms) == (correct, correct and smooth)
        errors.append(relative_error(frame.radiance(), exact))
    # By themselves a few rays a pixel are noise, which is for many frames to average.
    if smooth:
        assert errors[1] < 0.7 * errors[0]
    else:
        assert errors[1] != errors[0]
