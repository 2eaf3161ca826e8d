"""The layout of the code: imports go down, kernels have their own names, functions few parameters, files few lines.

All is read from the source; nothing is imported.
"""

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Packages and modules of gpu/, from the top down: each may import what stands below it, not what stands beside it.
GPU = [
    ["warm_up"],
    ["renderer"],
    ["methods"],
    ["sample_counts"],
    ["settings"],
    ["adaptive"],
    ["correction"],
    ["indirect"],
    ["direct", "vpl", "denoise", "sp"],
    ["gbuffer"],
    ["lights"],
    ["device_scene", "clustering"],
    ["sampling", "film"],
    ["scene", "core"],
    ["errors", "child_process"],
]
# Who knows the settings of users; what is below gets plain arguments.
KNOWS_SETTINGS = {"warm_up", "renderer", "methods", "sample_counts"}
MOST_PARAMETERS, MOST_LINES = 8, 500


@cache
def sources_of(folder: str) -> dict[str, ast.Module]:
    paths = sorted((ROOT / folder).rglob("*.py"))
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in paths]
    return {name: ast.parse(path.read_text()) for name, path in zip(names, paths, strict=True)}


def sources(*folders: str) -> dict[str, ast.Module]:
    """The modules of folders by their dotted names."""
    return {name: tree for folder in folders for name, tree in sources_of(folder).items()}


def imports(tree: ast.Module, modules: set[str]) -> Iterator[str]:
    """The modules of the project that a module imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            named = {f"{node.module}.{alias.name}" for alias in node.names} & modules
            yield from named
            if node.module in modules and len(named) < len(node.names):
                yield node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)


@cache
def graph(*folders: str) -> dict[str, set[str]]:
    trees = sources(*folders)
    return {name: set(imports(tree, set(trees))) - {name} for name, tree in trees.items()}


def functions(tree: ast.Module) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def is_kernel(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    names = [decorator.func if isinstance(decorator, ast.Call) else decorator for decorator in function.decorator_list]
    return any(isinstance(name, ast.Attribute) and name.attr == "kernel" for name in names)


def test_imports_of_gpu_go_down() -> None:
    layers = {name: layer for layer, names in enumerate(reversed(GPU)) for name in names}
    up = []
    for module, imported in graph("gpu").items():
        package = module.split(".")[1] if "." in module else None
        for other in imported:
            below = other.split(".")[1] if "." in other else None
            if package is None or below is None or package == below:
                continue
            if layers[package] <= layers[below] or (below == "settings" and package not in KNOWS_SETTINGS):
                up.append(f"{module} imports {other}")
    assert up == []


def test_a_scene_knows_nothing_of_the_formats_that_it_comes_in() -> None:
    """Only what looks a file's reader up does."""
    formats = "gpu.scene.formats"
    knowing = {
        module
        for module, imported in graph("gpu").items()
        if module.startswith("gpu.scene.") and not module.startswith(formats)
        if any(other.startswith(formats) for other in imported)
    }
    assert knowing == {"gpu.scene.load"}


def test_gpu_knows_nothing_of_the_server() -> None:
    edges = graph("gpu", "server")
    assert {m for m in edges if m.startswith("gpu") and any(other.startswith("server") for other in edges[m])} == set()


def test_no_modules_import_each_other_in_a_circle() -> None:
    edges, done, circles = graph("gpu", "server"), set(), []

    def visit(module: str, way: tuple[str, ...]) -> None:
        if module in way:
            circles.append(" → ".join([*way[way.index(module) :], module]))
        elif module not in done:
            for other in sorted(edges[module]):
                visit(other, (*way, module))
            done.add(module)

    for module in edges:
        visit(module, ())
    assert circles == []


def test_only_methods_ask_which_method_it_is() -> None:
    asking = [
        module
        for module, tree in sources("gpu", "server").items()
        if not module.startswith("gpu.methods")
        and module != "gpu.settings"
        and any(
            isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "Method"
            for node in ast.walk(tree)
        )
    ]
    assert asking == []


def test_every_kernel_has_a_name_of_its_own() -> None:
    names = Counter(node.name for tree in sources("gpu").values() for node in functions(tree) if is_kernel(node))
    assert {name: count for name, count in names.items() if count > 1 or name == "kernel"} == {}


def calls(tree: ast.AST) -> Iterator[tuple[str, list[ast.expr]]]:
    """Names of the functions that are called, and what with."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", ""), node.args


def test_kernels_whose_items_add_to_the_same_elements_are_launched_together() -> None:
    """On a CPU, slices of a launch run side by side, and atomics are none there."""
    adding = {"atomic_add", "atomic_min", "atomic_max", "count_in", "room_in"}
    trees = sources("gpu").values()
    functions = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    found = {it.name for it in functions if it.name.endswith("_kernel") and adding & {name for name, _ in calls(it)}}
    assert len(found) > 4
    for name, arguments in (call for tree in trees for call in calls(tree)):
        if name == "launch" and arguments:
            kernel = arguments[0].func if isinstance(arguments[0], ast.Call) else arguments[0]
            assert not (isinstance(kernel, ast.Name) and kernel.id in found), kernel.id


def test_no_function_has_many_parameters() -> None:
    """The first item of a launch, which every kernel takes, does not count, nor does a method's own object."""
    many = []
    for module, tree in sources("gpu", "server").items():
        for node in functions(tree):
            args = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
            own = [arg.arg for arg in args if arg.arg not in ("self", "cls")]
            count = len(own) - (is_kernel(node) and own[:1] == ["first"])
            if count > MOST_PARAMETERS:
                many.append(f"{module}.{node.name}: {count}")
    assert many == []


def test_no_file_is_long() -> None:
    paths = [path for folder in ("gpu", "server", "tests") for path in (ROOT / folder).rglob("*.py")]
    paths += list((ROOT / "web").rglob("*.js"))
    lines = {str(path.relative_to(ROOT)): path.read_text().count("\n") for path in paths}
    assert {path: count for path, count in lines.items() if count > MOST_LINES} == {}


def only_declares(tree: ast.Module) -> bool:
    """Whether a module has no functions: it declares constants, structs and errors, which who uses them tests."""
    return not any(not function.name.startswith("__") for function in functions(tree))


def test_every_module_has_a_test_where_it_is_looked_for() -> None:
    missing = []
    for module, tree in sources("gpu", "server").items():
        path = Path(*module.split("."))
        is_package = (ROOT / path / "__init__.py").exists()
        test = ROOT / "tests" / path.with_name(f"test_{path.name}.py")
        if not is_package and not only_declares(tree) and not test.exists():
            missing.append(module)
    assert missing == []
