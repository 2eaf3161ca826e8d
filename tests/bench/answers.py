"""What every scene file in a folder is answered with: `python -m tests.bench.answers FOLDER [--json FILE]`.

One line a file: its triangles and remarks, or the sentence that refuses it. An exception that is no UserError, which
users would meet as a traceback, is printed with FAULT, and the status is 1.
"""

import argparse
import json
import sys
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

from gpu.errors import UserError
from gpu.scene.load import SUFFIXES, load_scene


@dataclass(frozen=True)
class Answer:
    """What a file, by its name in the folder, is answered with. kind: "read", "refused" or "FAULT"."""

    file: str
    kind: str
    triangles: int = 0
    said: tuple[str, ...] = ()


def answer(folder: Path, path: Path) -> Answer:
    """The answer to the scene file at `path` in `folder`."""
    name = path.relative_to(folder).as_posix()
    try:
        scene = load_scene(str(path))
    except UserError as error:
        return Answer(name, "refused", said=(str(error).removeprefix(f"{path}: "),))
    except Exception as error:
        return Answer(name, "FAULT", said=(f"{type(error).__name__}: {error}",))
    return Answer(name, "read", len(scene.triangles), (*scene.report.ignored, *scene.report.notes))


def answers(folder: Path) -> list[Answer]:
    """The answers to all scene files below `folder`, by name."""
    return [answer(folder, path) for path in sorted(folder.rglob("*")) if path.suffix.lower() in SUFFIXES]


def main() -> int:
    """Print the answers to a folder's files."""
    command = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    command.add_argument("folder", type=Path)
    command.add_argument("--json", type=Path, help="also write them as JSON")
    options = command.parse_args()
    found = answers(options.folder)
    for one in found:
        shown = f"{one.triangles:,} triangles" if one.kind == "read" else one.kind
        print(f"{one.file}: {'; '.join((shown, *one.said))}")
    counts = Counter(one.kind for one in found)
    print(", ".join(f"{kind} {count}" for kind, count in sorted(counts.items())))
    if options.json:
        options.json.write_text(json.dumps([asdict(one) for one in found], indent=1, ensure_ascii=False))
    return 1 if counts["FAULT"] else 0


if __name__ == "__main__":
    sys.exit(main())
