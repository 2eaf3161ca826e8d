import pytest
from pictures import lamp_room, picture, relative_error
from scenes import slats

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.settings import Clustering, Component, Method, RenderSettings, Weighting


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


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
