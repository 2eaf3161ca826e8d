from pathlib import Path

import pytest

from gpu.scene.builtin import BUILTIN
from gpu.settings import RenderSettings, Skips
from server.settings import ServerSettings

README = (Path(__file__).parents[1] / "README.md").read_text()


@pytest.mark.parametrize(
    "name", [*RenderSettings.model_fields, *Skips.model_fields, *ServerSettings.model_fields, *BUILTIN]
)
def test_every_option_and_scene_is_in_the_readme(name: str) -> None:
    if name == "scene_limits":
        assert "[scene_limits]" in README
    else:
        assert f"`{name}`" in README or f"`--{name.replace('_', '-')}`" in README
