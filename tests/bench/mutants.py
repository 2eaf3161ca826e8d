"""Whether tests notice that a number which decides quality is another: each is doubled and halved, in a copy of code.

    python -m tests.bench.mutants [PART …]

Numbers are the defaults of dataclasses called …Parameters, and what instances at the top of a module have instead; not
zeros and names of other numbers. PART: what `module.Class.field` of those that are tried contains; all, if none is
named. A mutant meets the tests of its module, then others that import it, then those of modules that do. Prints each,
and exits with 1 where one survives.
"""

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[2]
COPIED = ("gpu", "server", "tests")
NUMBERS = {"int": "//", "float": "/"}
SECONDS = 600.0


@dataclass(frozen=True)
class Number:
    """A number in the source: `path` of its module in the repository, its name, where it stands [bytes], and its type.

    end: behind its last byte.
    """

    path: Path
    name: str
    begin: int
    end: int
    kind: str

    def mutated(self, source: bytes, *, doubled: bool) -> bytes:
        """The module's `source` with this number twice as large, or half."""
        change = b"* 2" if doubled else f"{NUMBERS[self.kind]} 2".encode()
        return source[: self.begin] + b"((" + source[self.begin : self.end] + b") " + change + b")" + source[self.end :]


def _fields(node: ast.ClassDef) -> dict[str, tuple[str, ast.expr]]:
    """Type and default of each number in a class of parameters; none in others."""
    own = [item for item in node.body if isinstance(item, ast.AnnAssign) and node.name.endswith("Parameters")]
    typed = {ast.unparse(item.target): (ast.unparse(item.annotation), item.value) for item in own}
    return {name: (kind, value) for name, (kind, value) in typed.items() if value and kind in NUMBERS}


def _calls(tree: ast.Module) -> Iterator[ast.Call]:
    """Calls at the top of a module, which make instances that it keeps."""
    statements = [node for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign) and node.value]
    return (node for statement in statements for node in ast.walk(statement) if isinstance(node, ast.Call))


def numbers(folder: Path, root: Path) -> list[Number]:
    """Those that decide quality in the modules below `folder`, but for zeros and names of others."""
    trees = {path: ast.parse(path.read_bytes()) for path in sorted(folder.rglob("*.py"))}
    known: dict[str, dict[str, str]] = {}
    found: list[Number] = []

    def add(path: Path, owner: str, field: str, kind: str, value: ast.expr) -> None:
        literals = [node.value for node in ast.walk(value) if isinstance(node, ast.Constant)]
        if not any(literals):
            return
        lines = path.read_bytes().splitlines(keepends=True)
        begin, end = (
            sum(map(len, lines[: line - 1])) + column
            for line, column in ((value.lineno, value.col_offset), (value.end_lineno or 0, value.end_col_offset or 0))
        )
        module = ".".join(path.relative_to(root).with_suffix("").parts)
        found.append(Number(path.relative_to(root), f"{module}.{owner}.{field}", begin, end, kind))

    for path, tree in trees.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and (fields := _fields(node)):
                inherited = [known.get(ast.unparse(base), {}) for base in node.bases]
                known[node.name] = {name: kind for base in inherited for name, kind in base.items()}
                known[node.name] |= {name: kind for name, (kind, _) in fields.items()}
                for name, (kind, value) in fields.items():
                    add(path, node.name, name, kind, value)
    for path, tree in trees.items():
        for call in _calls(tree):
            named = call.args[0] if ast.unparse(call.func) == "parameters" and call.args else call.func
            kinds = known.get(ast.unparse(named), {})
            for keyword in call.keywords:
                if keyword.arg in kinds:
                    owner = f"{ast.unparse(named)}@{call.lineno}"
                    add(path, owner, keyword.arg, kinds[keyword.arg], keyword.value)
    return found


def files_of(path: Path, root: Path) -> list[list[str]]:
    """Test files that a mutant of the module at `path` meets, in groups, one after another."""
    imported = f"from {'.'.join(path.with_suffix('').parts)} import"

    def test_of(module: Path) -> Path:
        return root / "tests" / module.with_name(f"test_{module.name}").relative_to(root)

    own = test_of(root / path)
    direct = [test for test in sorted((root / "tests/gpu").rglob("test_*.py")) if imported in test.read_text()]
    users = [test_of(module) for module in sorted((root / "gpu").rglob("*.py")) if imported in module.read_text()]
    groups, met = [], set[Path]()
    for group in [own], direct, users:
        tests = [test for test in dict.fromkeys(group) if test.exists() and test not in met]
        met.update(tests)
        groups.append([str(test.relative_to(root)) for test in tests])
    return [group for group in groups if group]


def passes(root: Path, files: list[str]) -> bool:
    """Whether all tests in `files` pass, in time."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *files]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    try:
        done = subprocess.run(command, cwd=root, env=environment, capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def main() -> int:
    """Try what the command line names; returns the exit status."""
    parts, survivors = sys.argv[1:], []
    with TemporaryDirectory() as folder:
        root = Path(folder)
        for name in COPIED:
            ignored = shutil.ignore_patterns("node_modules", "__pycache__")
            shutil.copytree(ROOT / name, root / name, ignore=ignored)
        shutil.copy(ROOT / "pyproject.toml", root)
        tried = [each for each in numbers(root / "gpu", root) if not parts or any(part in each.name for part in parts)]
        sound = {path: passes(root, files_of(path, root)[0]) for path in dict.fromkeys(each.path for each in tried)}
        for number in tried:
            if not sound[number.path]:
                print(f"tests fail without a mutant: {number.name}", flush=True)
                continue
            source = (root / number.path).read_bytes()
            for doubled in (True, False):
                (root / number.path).write_bytes(number.mutated(source, doubled=doubled))
                survives = all(passes(root, files) for files in files_of(number.path, root))
                change = "×2" if doubled else "÷2"
                print(f"{'SURVIVES' if survives else 'noticed '} {number.name} {change}", flush=True)
                survivors += [number.name] if survives else []
            (root / number.path).write_bytes(source)
    return int(bool(survivors) or not all(sound.values()))


if __name__ == "__main__":
    sys.exit(main())
