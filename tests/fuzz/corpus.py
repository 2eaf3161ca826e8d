"""Files that runs of the fuzzer have made and that reach what seeds do not: a zip file in the repository, so that the
next run, and the tests, begin with them.
"""

import zipfile
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from tests.fuzz.seed import Seed

CORPUS = Path(__file__).with_name("corpus.zip")
Found = tuple[Seed, frozenset[int]]
"""A file with the numbers of the edges that it reaches."""


def fewest(found: Iterable[Found]) -> list[Seed]:
    """Some of the files that reach all that the `found` ones do, found in this order."""
    left = list(found)
    reached = Counter(edge for _, edges in left for edge in edges)
    kept: list[Seed] = []
    for seed, edges in left:  # those found first reach what those made of them reach as well
        if all(reached[edge] > 1 for edge in edges):
            reached.subtract(edges)
        else:
            kept.append(seed)
    return kept


def write(seeds: Iterable[Seed], path: Path = CORPUS) -> None:
    """Keep the files at `path`, as they are before they are packed."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        for number, seed in enumerate(seeds):
            for name, content in {seed.name: seed.content, **seed.beside}.items():
                archive.writestr(zipfile.ZipInfo(f"{seed.name}/{number:04}/{name}"), content, zipfile.ZIP_LZMA)


def read(of: Iterable[Seed], path: Path = CORPUS) -> list[Seed]:
    """What is kept at `path` of the kinds that these seeds are of."""
    known = {seed.name: seed for seed in of}
    folders: defaultdict[str, dict[str, bytes]] = defaultdict(dict)
    if path.exists():
        with zipfile.ZipFile(path) as archive:
            for entry in archive.namelist():
                folder, _, name = entry.rpartition("/")
                folders[folder][name] = archive.read(entry)
    found = [(known.get(folder.partition("/")[0]), files) for folder, files in folders.items()]
    return [replace(seed, content=files.pop(seed.name), beside=files) for seed, files in found if seed is not None]
