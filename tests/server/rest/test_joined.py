import gzip
import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from server.rest.joined import PLACE, Joined
from server.rest.pages import FOLDER

DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
PAGE = {
    "index.html": '<link rel="stylesheet" href="style/all.css"><a href="https://a.example/b.css"></a>\n'
    '<script type="module" src="main.js"></script>\n',
    "style/all.css": '@import "base.css";\n@import "small.css";\n',
    "style/base.css": "p { color: red }\n",
    "style/small.css": "p { color: blue }\n",
    "counter.js": "let count = 0;\n"
    + "export function next() {\n  count += 1;\n  return count;\n}\nexport class Counter {}\n",
    "ui/one.js": 'import { next as more } from "../counter.js";\nexport const ONE = more();\n'
    "export const place = import.meta.url;\nconst own = 1;\n",
    "main.js": 'import {\n  next,\n  Counter,\n} from "./counter.js";\nimport { ONE, place } from "./ui/one.js";\n\n'
    "const own = await Promise.resolve([ONE, next(), typeof Counter, place]);\nconsole.log(JSON.stringify(own));\n",
}


def folder_of(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def text_of(joined: Joined, name: str) -> str:
    text = joined.text(name)
    assert text is not None
    assert gzip.decompress(text.packed) == text.plain
    return text.plain.decode()


def test_a_joined_module_does_what_its_files_do(tmp_path: Path) -> None:
    if shutil.which("node") is None:
        pytest.skip("needs Node")
    joined = Joined(folder_of(tmp_path / "web", PAGE))
    (tmp_path / "main.mjs").write_text(text_of(joined, "main.js"))
    said = subprocess.run(["node", tmp_path / "main.mjs"], capture_output=True, text=True, check=True).stdout
    # Each module ran once, with names of its own, and knows where its file would be.
    assert json.loads(said) == [1, 2, "function", (tmp_path / "ui" / "one.js").as_uri()]


def test_a_page_names_what_is_joined_by_the_digest_of_its_files(tmp_path: Path) -> None:
    joined = Joined(folder_of(tmp_path, PAGE))
    page = text_of(joined, "index.html")
    assert f'href="{PLACE}/{joined.digest}/style/all.css"' in page
    assert f'src="{PLACE}/{joined.digest}/main.js"' in page
    assert 'href="https://a.example/b.css"' in page
    assert text_of(joined, "style/all.css") == PAGE["style/base.css"] + PAGE["style/small.css"]
    before = joined.digest
    joined.look()
    assert joined.digest == before
    (tmp_path / "style" / "small.css").write_text("p { color: green }\n")
    os.utime(tmp_path / "style" / "small.css", (1, 1))
    joined.look()
    assert joined.digest != before
    assert "green" in text_of(joined, "style/all.css")
    assert joined.digest in text_of(joined, "index.html")


@pytest.mark.parametrize("name", ["nothing.js", "main.css", "style/all.css.map", "../web/main.js", ""])
def test_nothing_else_is_joined(tmp_path: Path, name: str) -> None:
    assert Joined(folder_of(tmp_path, PAGE)).text(name) is None


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('import "./counter.js";\n', "cannot be joined"),
        ('import all from "./counter.js";\n', "cannot be joined"),
        ("const a = 1;\nexport { a };\n", "cannot be joined"),
        ("export default 1;\n", "cannot be joined"),
        ('import { ONE } from "../main.js";\nexport const TWO = ONE;\n', "imports itself"),
    ],
)
def test_modules_that_cannot_be_joined_are_told(tmp_path: Path, text: str, problem: str) -> None:
    joined = Joined(folder_of(tmp_path, PAGE | {"ui/one.js": text}))
    with pytest.raises(ValueError, match=problem):
        joined.text("main.js")


def numbers(digits: str) -> list[int]:
    """Those of a segment of a source map."""
    found, value, shift = list[int](), 0, 0
    for digit in map(DIGITS.index, digits):
        value, shift = value | (digit & 31) << shift, shift + 5
        if not digit & 32:
            found, value, shift = [*found, -(value >> 1) if value & 1 else value >> 1], 0, 0
    return found


@pytest.mark.parametrize("name", ["main.js", "viewer/paint-worker.js", "ui/theme.js"])
def test_source_maps_lead_to_the_lines_of_the_pages_files(name: str) -> None:
    joined = Joined(FOLDER)
    lines = text_of(joined, name).splitlines()
    map_ = json.loads(text_of(joined, f"{name}.map"))
    assert lines[-1] == f"//# sourceMappingURL={Path(name).name}.map"
    place = Path("/") / PLACE / "digest" / name
    source, line, told = 0, 0, set[tuple[Path, int]]()
    for joined_line, segment in zip(lines, map_["mappings"].split(";"), strict=False):
        if not segment:
            continue
        column, more_sources, more_lines, _ = numbers(segment)
        source, line = source + more_sources, line + more_lines
        file = FOLDER / Path(os.path.normpath(place.parent / map_["sources"][source])).relative_to("/")
        text = file.read_text().splitlines()[line]
        assert column == 0
        assert text == joined_line or text.startswith(("import ", "export ", "}")) or "import.meta" in text
        told.add((file, line))
    assert {file for file, _ in told} >= {FOLDER / name}
    assert len(told) == sum(file.read_text().count("\n") for file in {file for file, _ in told})
