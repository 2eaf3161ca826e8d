from pictures import SIZE, lamp_room

from gpu.methods.gather_view_state import GatherViewState


def test_a_view_has_no_centres_at_first_nor_once_its_scene_has_changed() -> None:
    view = GatherViewState(lamp_room(), SIZE, 20)
    assert not view.keeps_centres
    assert view.centres.used.numpy().tolist() == [0] * 20
    view.keeps_centres = True
    view.forget()
    assert not view.keeps_centres
