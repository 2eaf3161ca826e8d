from pathlib import Path

import pytest

from gpu.errors import UserError
from tests.load.figures import crowd_row
from tests.load.results import save
from tests.load.soak import Record, Soak, soak_row
from tests.load.test_figures import log
from tests.load.viewer import Plan

pytest.importorskip("matplotlib", reason="needs matplotlib, of the extra `bench`")

from tests.load.plots import draw, plot_ramp

OPTIONS = {"size": [96, 54], "hz": 30.0, "scene": "cornell-box"}
COMMON = {"environment": {"device": "a device"}, "options": OPTIONS}


def test_results_are_drawn(tmp_path: Path) -> None:
    rows = [crowd_row([log(10, 20.0 * count, number) for number in range(count)], 0.0, 10.0, {}) for count in (1, 4)]
    save(tmp_path, "ramp", {**COMMON, "level": {"age": 100.0, "fps": 10.0}, "rows": rows})
    samples = [{"seconds": float(at), "viewers": at % 3, "web_mb": 70.0, "worker_mb": 200.0 + at} for at in range(60)]
    save(tmp_path, "soak", {**COMMON, "row": soak_row(Record(samples=samples), Soak(Plan(), 60.0))})
    made = draw(tmp_path)
    assert [file.name for file in made] == ["ramp.png", "soak.png"]
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in made)


def test_a_title_tells_the_scene_if_one_was_chosen() -> None:
    rows = [crowd_row([log(10, 20.0)], 0.0, 10.0, {})]

    def title(options: dict[str, object]) -> str:
        figure = plot_ramp({**COMMON, "options": options, "level": {"age": 100.0, "fps": 10.0}, "rows": rows})
        # Wherever the style of other plots puts it.
        return "".join(figure.axes[0].get_title(place) for place in ("left", "center"))

    assert title(OPTIONS).endswith("96×54, poses at 30 Hz, cornell-box")
    assert title({"size": [96, 54], "hz": 30.0}).endswith("96×54, poses at 30 Hz")


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="to plot"):
        draw(tmp_path)
    (tmp_path / "ramp.json").write_text("{")
    with pytest.raises(UserError, match=r"ramp\.json"):
        draw(tmp_path)
