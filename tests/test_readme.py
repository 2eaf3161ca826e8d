import re
import shlex
from pathlib import Path

from gpu.scene.builtin import BUILTIN
from gpu.settings import RenderSettings
from server.cli.commands import parser
from server.settings import ServerSettings
from server.video.film_settings import FilmSettings

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
# Options of commands that no model has.
COMMANDS = {"--json", "--size", "--camera", "--path", "--edit", "--config"}


def test_the_readme_is_a_page_that_one_reads() -> None:
    assert len(README.splitlines()) <= 250


def test_every_option_in_the_readme_exists() -> None:
    models = [*RenderSettings.model_fields, *FilmSettings.model_fields, *ServerSettings.model_fields]
    known = COMMANDS | {"--" + name.replace("_", "-") for name in models}
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))
    assert named <= known
    assert "--target-ms" in named


def test_every_command_in_the_readme_is_understood() -> None:
    commands = re.findall(r"^(?:    |`)lumenwalk (.+?)`?$", README, re.M)
    understood = [parser().parse_args(shlex.split(command, comments=True)).command for command in commands]
    assert len(set(understood)) == 3  # render, compare and info; `make run` serves


def test_every_built_in_scene_is_in_the_readme() -> None:
    assert all(f"`{name}`" in README for name in BUILTIN)


def test_every_page_of_docs_is_linked_from_the_readme() -> None:
    assert all(f"(docs/{page.name})" in README for page in (ROOT / "docs").glob("*.md"))


def test_the_library_snippet_renders() -> None:
    (snippet,) = re.findall(r"```python\n(.*?)```", README, re.S)
    (walk,) = re.findall(r"`(view = renderer\.new_view\(\))`", README)
    (frame,) = re.findall(r"`(renderer\.render\(camera, view=view, walks=True\))`", README)
    for there, here in (('"house.glb")', '"cornell-box"), "cpu"'), ("(1280, 720)", "(48, 32)")):
        assert there in snippet
        snippet = snippet.replace(there, here)
    names: dict[str, object] = {}
    exec(f"{snippet}\ncamera = look_at(eye=(0, 1, 3), target=(0, 1, 0))\n{walk}\nwalked = {frame}\n", names)
    for name in ("frame", "walked"):
        exec(f"shape = {name}.pixels().shape, str({name}.radiance().dtype)", names)
        assert names["shape"] == ((32, 48, 3), "float32")
