from pathlib import Path

from tests.bench.mutants import files_of, numbers

CODE = """
@dataclass(frozen=True)
class Parameters:
    '''What é means.'''

    width: int
    share: float = 0.5
    most: int = 3
    none: int = 0
    names: tuple[str, ...] = ()

@dataclass
class Place:
    y: int = 2

USUAL = Parameters()
OTHER: Parameters = parameters(Parameters, most=2 * 4)
"""


def test_each_number_is_doubled_and_halved_where_it_stands(tmp_path: Path) -> None:
    module = tmp_path / "gpu/stage.py"
    module.parent.mkdir()
    module.write_text(CODE)
    found = {number.name.removeprefix("gpu.stage."): number for number in numbers(tmp_path / "gpu", tmp_path)}
    assert list(found) == ["Parameters.share", "Parameters.most", f"Parameters@{CODE.count(chr(10))}.most"]
    for name, text, doubled, halved in (
        ("Parameters.share", "0.5", "((0.5) * 2)", "((0.5) / 2)"),
        ("Parameters.most", "most: int = 3", "most: int = ((3) * 2)", "most: int = ((3) // 2)"),
        (f"Parameters@{CODE.count(chr(10))}.most", "2 * 4", "((2 * 4) * 2)", "((2 * 4) // 2)"),
    ):
        for mutant, is_doubled in (doubled, True), (halved, False):
            assert found[name].mutated(CODE.encode(), doubled=is_doubled).decode() == CODE.replace(text, mutant)


def test_a_mutant_meets_the_tests_of_its_module_of_what_imports_it_and_of_modules_that_do(tmp_path: Path) -> None:
    uses = "from gpu.stage import run"
    files = {"gpu/stage": "", "gpu/user": uses, "gpu/far": "", "tests/gpu/test_far": "import gpu",
             "tests/gpu/test_other": uses, "tests/gpu/test_stage": uses, "tests/gpu/test_user": ""}  # fmt: skip
    for name, text in files.items():
        path = tmp_path / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    groups = [["tests/gpu/test_stage.py"], ["tests/gpu/test_other.py"], ["tests/gpu/test_user.py"]]
    assert files_of(Path("gpu/stage.py"), tmp_path) == groups
