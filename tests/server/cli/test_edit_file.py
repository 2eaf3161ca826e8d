from pathlib import Path

import pytest

from gpu.errors import UserError
from gpu.scene.edits import LightEdit, SceneEdits
from server.cli.edit_file import read_edits


def test_a_file_of_edits_is_read(tmp_path: Path) -> None:
    path = tmp_path / "edits.json"
    path.write_text('{"lights": {"lamp": {"on": false}, "sky": {}}}')
    assert read_edits(path) == SceneEdits(lights={"lamp": LightEdit(on=False)})


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_editors_may_mark_its_encoding(encoding: str, tmp_path: Path) -> None:
    path = tmp_path / "edits.json"
    path.write_text('{"lights": {"Küche": {"on": false}}}', encoding=encoding)
    assert read_edits(path) == SceneEdits(lights={"Küche": LightEdit(on=False)})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "cannot be read"),
        ("{", "Invalid JSON"),
        ("\xff", "Invalid JSON"),
        ("[1]", "must be an object"),
        ('{"lights": {"lamp": {"on": 2}}}', "lights.lamp.on: must be a valid boolean"),
    ],
)
def test_what_is_wrong_with_it_is_said(text: str | None, words: str, tmp_path: Path) -> None:
    path = tmp_path / "edits.json"
    if text is not None:
        path.write_text(text, encoding="latin-1")
    with pytest.raises(UserError, match=f"^--edit: {path}: .*{words}"):
        read_edits(path)
