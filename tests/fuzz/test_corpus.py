from pathlib import Path

from tests.fuzz import corpus
from tests.fuzz.seed import Seed


def test_what_others_reach_as_well_is_not_kept() -> None:
    found = [(Seed("a", bytes([number])), frozenset(edges)) for number, edges in enumerate([{1}, {1, 2}, {3}, {2, 3}])]
    assert [seed.content for seed in corpus.fewest(found)] == [b"\1", b"\3"]


def test_files_are_kept_before_they_are_packed(tmp_path: Path) -> None:
    kinds = [Seed("a.3mf", b"", pack=bytes.upper), Seed("a.obj", b"", {"a.mtl": b""})]
    kept = [Seed("a.3mf", b"x"), Seed("a.obj", b"y", {"a.mtl": b"z"}), Seed("a.other", b"")]
    path = tmp_path / "corpus.zip"
    corpus.write(kept, path)
    first = path.read_bytes()
    corpus.write(kept, path)
    assert path.read_bytes() == first
    assert [seed.files() for seed in corpus.read(kinds, path)] == [{"a.3mf": b"X"}, {"a.obj": b"y", "a.mtl": b"z"}]
    assert corpus.read(kinds, tmp_path / "none.zip") == []
