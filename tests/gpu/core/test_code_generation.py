import numpy as np
import pytest
import warp as wp

from gpu.core.code_generation import pass_by_reference, tell_constants
from gpu.core.device import launch

CPU = wp.get_device("cpu")


@pass_by_reference
@wp.struct
class Room:
    height: float
    lamps: int
    lit: bool
    heights: wp.array[float]


@wp.func
def lamp_light(room: Room) -> float:
    return 100.0 * float(room.lamps)


@wp.func
def light(room: Room) -> float:
    if room.lit and room.lamps > 0:
        return lamp_light(room)
    return 1.0


@wp.func
def raised(room: Room, by: float) -> float:
    room.height += by
    return room.height


@wp.func
def without_lamps(room: Room) -> float:
    darker = room
    darker.lamps = 0
    return light(darker)


@wp.func
def steps_to(room: Room, most: int) -> int:
    left = room.lamps
    for _ in range(most):
        left += 1
    return left


def room_kernel() -> wp.Kernel:
    """A kernel of its own at each call."""

    @wp.kernel(module="unique")
    def room_kernel(first: int, room: Room, found: wp.array[float]) -> None:
        found[0] = light(room)
        found[1] = raised(room, 1.0)
        found[2] = room.height
        found[3] = without_lamps(room)
        found[4] = float(steps_to(room, int(found[5])))

    return room_kernel


def code_of(kernel: wp.Kernel, device: str) -> str:
    module = kernel.module
    return str(wp._src.context.ModuleBuilder(module, module.resolve_options(wp.config)).codegen(device))


def function_of(code: str, name: str) -> str:
    """A function's head and body."""
    return code[code.index(f" {name}_") :].split("\n}")[0]


def found_by(kernel: wp.Kernel, room: Room) -> list[float]:
    found = wp.array([0.0] * 5 + [3.0], dtype=float, device=CPU)
    launch(kernel, 1, [room, found], CPU)
    return np.asarray(found.numpy()).tolist()


@pytest.fixture
def room() -> Room:
    room = Room()
    room.height, room.lamps, room.lit = 2.0, 3, True
    return room


def test_what_a_function_writes_to_a_struct_is_its_own(room: Room) -> None:
    assert found_by(room_kernel(), room)[:5] == [300.0, 3.0, 2.0, 1.0, 6.0]


def test_functions_take_structs_that_they_do_not_write_to_by_reference() -> None:
    code = code_of(room_kernel(), "cuda")
    by_reference = {name: "& var_room" in function_of(code, name).split(")")[0] for name in ("light", "raised")}
    assert by_reference == {"light": True, "raised": False}


def test_functions_are_inlined_by_compilers_for_gpus_alone() -> None:
    code = {device: code_of(room_kernel(), device) for device in ("cpu", "cuda")}
    assert {device: "WP_FORCEINLINE" in text for device, text in code.items()} == {"cpu": False, "cuda": True}


def told_kernel() -> wp.Kernel:
    @wp.kernel(module="unique")
    def told_kernel(first: int, room: Room, found: wp.array[float]) -> None:
        room.lamps = 0
        found[0] = light(room)
        found[4] = float(steps_to(room, int(found[5])))

    return told_kernel


def test_code_is_made_without_what_constants_leave_out(room: Room) -> None:
    assert "lamp_light" in code_of(told_kernel(), "cpu")
    kernel = told_kernel()
    tell_constants(kernel, Room, {"lamps": 0})
    assert "lamp_light" not in code_of(kernel, "cpu")
    found = found_by(kernel, room)
    assert (found[0], found[4]) == (1.0, 3.0)


def test_a_kernel_is_told_the_same_each_time() -> None:
    kernel = told_kernel()
    tell_constants(kernel, Room, {"lamps": 0})
    with pytest.raises(ValueError, match="told_kernel"):
        tell_constants(kernel, Room, {"lamps": 1})
