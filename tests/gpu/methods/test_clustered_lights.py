import pytest
from pictures import QUALITY, SIZE, lamp_room

from gpu.methods.frame_kind import frame_kind
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.method import RenderSetup
from gpu.sample_counts import sample_counts_of
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets


def test_what_is_known_of_lights_is_the_view_s_and_has_room_for_no_more_clusters() -> None:
    device_scene = lamp_room()
    settings = RenderSettings(**QUALITY)
    counts = sample_counts_of(settings, device_scene.device)
    setup = RenderSetup(device_scene, LightSets(device_scene), SIZE, settings, counts, lambda what, share: None)
    method = FuzzyVpl(setup)
    one, other = method.new_view(), method.new_view()
    lights = method.lights
    assert lights.known_to(one) is lights.known_to(one)
    assert lights.known_to(one) is not lights.known_to(other)
    assert lights.known_to(one).visibility.words.ptr != lights.known_to(other).visibility.words.ptr
    lights.check_room(200)
    with pytest.raises(ValueError, match="201 SP clusters where there is room for 200"):
        lights.check_room(201)
    assert lights.convergence(frame_kind(settings, one, 0)) is None
