import re
from pathlib import Path

from gpu.scene.builtin import BUILTIN
from gpu.settings import RenderSettings
from server.settings import ServerSettings

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
# Options of commands that no model has.
COMMANDS = {"--json", "--size", "--camera", "--config"}


def test_the_readme_is_a_page_that_one_reads() -> None:
    assert len(README.splitlines()) <= 250


def test_every_option_in_the_readme_exists() -> None:
    models = [*RenderSettings.model_fields, *ServerSettings.model_fields]
    known = COMMANDS | {"--" + name.replace("_", "-") for name in models}
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))
    assert named <= known
    assert "--target-ms" in named


def test_every_built_in_scene_is_in_the_readme() -> None:
    assert all(f"`{name}`" in README for name in BUILTIN)


def test_every_page_of_docs_is_linked_from_the_readme() -> None:
    assert all(f"(docs/{page.name})" in README for page in (ROOT / "docs").glob("*.md"))


def test_the_library_snippet_imports_what_there_is() -> None:
    (snippet,) = re.findall(r"```python\n(.*?)```", README, re.S)
    imports = "\n".join(line for line in snippet.splitlines() if line.startswith("from "))
    assert len(imports.splitlines()) == 5
    exec(imports, {})
