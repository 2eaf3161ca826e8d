from collections.abc import Iterator

import pytest
import warp as wp
from warp._src.codegen import Adjoint
from warp._src.context import ModuleHasher

from gpu.core.code_generation import pass_by_reference, tell_constants
from gpu.core.device import launch

CPU = wp.get_device("cpu")


@wp.struct
class Lamp:
    power: float


@pass_by_reference
@wp.struct
class House:
    floors: int
    lit: bool


@wp.func
def lamp_of(house: House) -> Lamp:
    lamp = Lamp()
    lamp.power = float(house.floors)
    return lamp


@wp.func
def power_of(house: House) -> float:
    if house.lit:
        return lamp_of(house).power
    return -1.0


@wp.func
def twice(value: float) -> float:
    return value * 2.0


@wp.func
def powers(house: House) -> float:
    return twice(power_of(house))


def house_kernel(offset: float) -> wp.Kernel:
    @wp.kernel(module="unique")
    def house_kernel(first: int, house: House, found: wp.array[float]) -> None:
        found[0] = powers(house) + offset

    return house_kernel


def code_of(kernel: wp.Kernel) -> str:
    module = kernel.module
    return str(wp._src.context.ModuleBuilder(module, module.resolve_options(wp.config)).codegen("cpu"))


def found_by(kernel: wp.Kernel) -> float:
    house, found = House(), wp.zeros(1, dtype=float, device=CPU)
    house.floors, house.lit = 3, True
    launch(kernel, 1, [house, found], CPU)
    return float(found.numpy()[0])


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Names of the functions and kernels that Warp reads anew."""
    names: list[str] = []
    build = Adjoint.build

    def noted(adj: Adjoint, *rest: object, **options: object) -> None:
        names.append(adj.fun_name)
        build(adj, *rest, **options)

    for function in (lamp_of, power_of, twice, powers):
        vars(function).pop("kept_builds", None)
    monkeypatch.setattr(Adjoint, "build", noted)
    return names


def test_a_function_is_read_once_for_all_kernels(built: list[str]) -> None:
    one, other = house_kernel(1.0), house_kernel(2.0)
    built.clear()
    first = code_of(one)
    assert sorted(built) == ["house_kernel", "lamp_of", "power_of", "powers", "twice"]
    built.clear()
    second = code_of(other)
    assert built == ["house_kernel"]
    assert all(second.count(f" {name}_0(") == first.count(f" {name}_0(") for name in ("lamp_of", "powers", "twice"))
    assert (found_by(one), found_by(other)) == (7.0, 8.0)


def test_only_what_reads_a_constant_is_read_anew(built: list[str]) -> None:
    plain, dark = house_kernel(3.0), house_kernel(4.0)
    tell_constants(dark, House, {"lit": False})
    code_of(plain)
    built.clear()
    assert "lamp_of" not in code_of(dark)
    assert built == ["house_kernel", "power_of"]
    assert (found_by(plain), found_by(dark)) == (9.0, 2.0)


def test_what_was_found_for_one_kernel_is_there_after_another(built: list[str]) -> None:
    plain, dark, again = house_kernel(5.0), house_kernel(6.0), house_kernel(7.0)
    tell_constants(dark, House, {"lit": False})
    code_of(plain), code_of(dark)
    built.clear()
    assert "lamp_of" in code_of(again)
    assert built == ["house_kernel"]
    assert found_by(again) == 13.0


def test_what_was_found_holds_after_warp_looked_for_something_else(built: list[str]) -> None:
    """As it does for how many threads a kernel may have that was compiled long ago."""
    dark, plain = house_kernel(8.0), house_kernel(9.0)
    tell_constants(dark, House, {"lit": False})
    code_of(dark)
    plain.adj.build(None, plain.module.resolve_options(wp.config))
    built.clear()
    assert "lamp_of" in code_of(plain)
    assert "power_of" in built
    assert (found_by(plain), found_by(dark)) == (15.0, 6.0)


def hash_of(function: wp.Function) -> bytes:
    """As another module takes it."""
    return bytes(ModuleHasher([], {}).hash_function(function))


def test_a_function_is_hashed_once_for_all_modules(monkeypatch: pytest.MonkeyPatch) -> None:
    names: list[str] = []
    hash_adjoint = ModuleHasher.hash_adjoint

    def noted(hasher: ModuleHasher, adj: Adjoint) -> bytes:
        names.append(adj.fun_name)
        return bytes(hash_adjoint(hasher, adj))

    monkeypatch.setattr(ModuleHasher, "hash_adjoint", noted)
    for function in (lamp_of, power_of, twice, powers):
        vars(function).pop("kept_hash", None)
    first = hash_of(powers)
    assert sorted(names) == ["lamp_of", "power_of", "powers", "twice"]
    assert (hash_of(powers), hash_of(twice) == first) == (first, False)
    assert len(names) == 4


def test_another_overload_is_hashed_anew() -> None:
    @wp.func
    def half(value: float) -> float:
        return value * 0.5

    before = hash_of(half)

    @wp.func
    def half(value: int) -> int:  # type: ignore[no-redef]
        return value // 2

    assert hash_of(half) != before


def test_nothing_is_gone_through_for_modules_that_would_be_loaded_again() -> None:
    assert house_kernel(1.0).module.references == set()
