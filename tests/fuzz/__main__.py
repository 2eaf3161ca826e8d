"""A long run: `python -m tests.fuzz --seconds 3600 --seed 7 --out build/fuzz`.

What reaches new lines of the readers is kept, in memory, to be changed further. Each fault is written into `out` once,
with its traceback; the exit status is 1 when there was one.
"""

import argparse
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path
from random import Random
from types import FrameType
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "gpu"))  # whose files make files

from tests.fuzz.mutate import mutated  # noqa: E402
from tests.fuzz.readers import read  # noqa: E402
from tests.fuzz.seeds import Seed, seeds  # noqa: E402

MOST_MEMORY = 4 * 1024**3
READERS = str(ROOT / "gpu" / "scene")


class Edges:
    """Which steps from line to line of the readers have been seen."""

    def __init__(self) -> None:
        self.seen: set[tuple[str, int, int]] = set()

    def watch(self, frame: FrameType, _: str, __: Any) -> Any:
        """For sys.settrace: follow the readers alone."""
        if not frame.f_code.co_filename.startswith(READERS):
            return None
        file, last = frame.f_code.co_filename, [0]

        def line(at: FrameType, event: str, _: Any) -> Any:
            if event == "line":
                self.seen.add((file, last[0], at.f_lineno))
                last[0] = at.f_lineno
            return line

        return line


def run(seconds: float, seed: int, out: Path) -> int:
    """Read mutations for that long; how many distinct faults there were."""
    out.mkdir(parents=True, exist_ok=True)
    dice, edges, counts = Random(seed), Edges(), Counter[str]()
    corpus: dict[str, list[Seed]] = {each.name: [each] for each in seeds()}
    faults = Counter[str]()
    began = told = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        while (now := time.monotonic()) < began + seconds:
            kind = corpus[dice.choice(list(corpus))]
            file = _changed(dice, dice.choice(kind), dice.choice(kind))
            before = len(edges.seen)
            sys.settrace(edges.watch)
            try:
                is_scene = read(Path(folder), file)
            except Exception as error:  # every kind is a fault
                sys.settrace(None)
                place = traceback.extract_tb(error.__traceback__)[-1]
                key = f"{type(error).__name__}-{Path(place.filename).stem}-{place.lineno}-{Path(file.name).suffix[1:]}"
                faults[key] += 1
                if faults[key] == 1:
                    _keep(out / key, file, traceback.format_exc())
                    print(f"{key}: {str(error)[:150]}", flush=True)
            else:
                sys.settrace(None)
                counts["scenes" if is_scene else "refused"] += 1
            if len(edges.seen) > before:
                kind.append(file)
            if now > told + 60:
                told = now
                print(f"{now - began:.0f} s: {dict(counts)}, {len(edges.seen)} edges, {dict(faults)}", flush=True)
    kept = sum(map(len, corpus.values()))
    print(
        f"seed {seed}: {dict(counts)}, {len(edges.seen)} edges, {kept} files kept, faults: {dict(faults)}", flush=True
    )
    return len(faults)


def _changed(dice: Random, file: Seed, other: Seed) -> Seed:
    """A mutation of a file, or of one beside it."""
    is_gltf = file.name.endswith(("glb", "gltf"))
    if file.beside and dice.random() < 0.5:
        name = dice.choice(list(file.beside))
        content = mutated(dice, file.beside[name], other.beside[name], is_gltf=False)
        return replace(file, beside=file.beside | {name: content})
    return replace(file, content=mutated(dice, file.content, other.content, is_gltf=is_gltf))


def _keep(folder: Path, file: Seed, why: str) -> None:
    folder.mkdir(exist_ok=True)
    for name, content in {file.name: file.content, **file.beside, "why.txt": why.encode(errors="replace")}.items():
        (folder / name).write_bytes(content)


def main() -> int:
    """Run as asked."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("build/fuzz"))
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    warnings.simplefilter("error")
    return int(run(options.seconds, options.seed, options.out) > 0)


if __name__ == "__main__":
    sys.exit(main())
