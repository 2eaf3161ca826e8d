from types import SimpleNamespace

import pytest

from server.cluster.scaling import FEWEST_VIEWERS, MOST_VIEWERS, scale, wanted_replicas


@pytest.mark.parametrize(
    ("busy", "viewers", "replicas"),
    [
        (0.0, 0, 1),
        (0.5, 10, 1),
        (1.0, FEWEST_VIEWERS, 1),  # who walks alone takes what there is
        (1.0, FEWEST_VIEWERS + 1, 2),
        (2.0, 40, 3),
        (0.0, MOST_VIEWERS, 1),
        (0.0, MOST_VIEWERS + 1, 2),
    ],
)
def test_devices_are_as_many_as_their_time_asks_for(busy: float, viewers: float, replicas: int) -> None:
    assert wanted_replicas(busy, viewers) == replicas


def test_what_the_replicas_say_is_added_up() -> None:
    said = {"busy": {"one": 0.9, "two": 0.7}, "viewers": {"one": 9.0, "two": 12.0}}
    assert scale(SimpleNamespace(aggregated_metrics=said))[0] == 3
    assert scale(SimpleNamespace(aggregated_metrics=None))[0] == 1
