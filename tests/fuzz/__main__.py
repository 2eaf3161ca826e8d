"""A long run: `python -m tests.fuzz --seconds 3600 --seed 7 --out build/fuzz`.

What reaches new lines of the readers is changed further; at the end `out`/corpus.zip has as few files as reach all that
was reached, which can take the place of the corpus that is kept beside this. Each fault is written into `out` once,
with its traceback; the exit status is 1 when there was one. Libraries may end the process that reads, as they may
in the service: that is counted, and no fault.
"""

import argparse
import os
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "gpu"))  # whose files make files

from server.scenes.checker import ONE_THREAD  # noqa: E402

os.environ |= ONE_THREAD  # before any library is loaded: a process of several threads is not copied safely

from tests.fuzz import corpus  # noqa: E402
from tests.fuzz.apart import EndedError, FaultError, apart, place_of, told  # noqa: E402
from tests.fuzz.edges import Edges  # noqa: E402
from tests.fuzz.mutate import mutated  # noqa: E402
from tests.fuzz.readers import read  # noqa: E402
from tests.fuzz.seed import Seed  # noqa: E402
from tests.fuzz.seeds import seeds  # noqa: E402
from tests.fuzz.seeds_of_libraries import library_of  # noqa: E402

MOST_MEMORY = 4 * 1024**3


class Run:
    """Files that are changed and read, and what came of it."""

    def __init__(self, seed: int, out: Path, folder: Path) -> None:
        self._dice, self._edges, self._out, self._folder = Random(seed), Edges(), out, folder
        self._kinds: dict[str, list[Seed]] = {}
        self.found: list[corpus.Found] = []
        self.counts, self.faults = Counter[str](), Counter[str]()

    def begin(self) -> None:
        """Read seeds and corpus; libraries are loaded once and for all."""
        first = seeds()
        for seed in first:
            self._kinds[seed.name] = []
            read(self._folder, seed)
        for seed in [*first, *corpus.read(first)]:
            self._try(seed, new=True)

    def step(self) -> None:
        """Change one file and read it."""
        kind = self._kinds[self._dice.choice(list(self._kinds))]
        self._try(_changed(self._dice, self._dice.choice(kind), self._dice.choice(kind)))

    def _try(self, file: Seed, *, new: bool = False) -> None:
        try:
            do = partial(self._edges.reached, partial(read, self._folder, file))
            is_scene, edges = apart(do) if library_of(file.name) else do()
        except EndedError as error:
            self.counts[f"{library_of(file.name)} ended by {error}"] += 1
            return
        except Exception as error:  # every kind is a fault
            self._fault(file, error)
            return
        self.counts["scenes" if is_scene else "refused"] += 1
        numbers, is_new = self._edges.numbered(edges)
        if new or is_new:
            self._kinds[file.name].append(file)
            self.found.append((file, numbers))

    def _fault(self, file: Seed, error: Exception) -> None:
        place, why = (error.place, error.why) if isinstance(error, FaultError) else (place_of(error), told(error))
        key = f"{place}-{Path(file.name).suffix[1:]}"
        self.faults[key] += 1
        if self.faults[key] == 1:
            _keep(self._out / key, file, why)
            print(f"{key}: {why.splitlines()[-1][:150]}", flush=True)

    def __str__(self) -> str:
        return (
            f"{dict(self.counts)}, {len(self._edges.numbers)} edges, {len(self.found)} files kept, {dict(self.faults)}"
        )


def run(seconds: float, seed: int, out: Path) -> int:
    """Read mutations for that long; how many distinct faults there were."""
    out.mkdir(parents=True, exist_ok=True)
    began = said = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        running = Run(seed, out, Path(folder))
        running.begin()
        while (now := time.monotonic()) < began + seconds:
            running.step()
            if now > said + 60:
                said = now
                print(f"{now - began:.0f} s: {running}", flush=True)
    corpus.write(corpus.fewest(running.found), out / "corpus.zip")
    print(f"seed {seed}: {running}", flush=True)
    return len(running.faults)


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
    for name, content in {**file.files(), "why.txt": why.encode(errors="replace")}.items():
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
