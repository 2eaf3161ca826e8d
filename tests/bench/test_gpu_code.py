import warp as wp

from tests.bench.gpu_code import compiled

SIZE = wp.constant(64)


@wp.kernel(module="unique", enable_backward=False)
def plain_kernel(values: wp.array[float]) -> None:
    values[wp.tid()] = 2.0 * values[wp.tid()]


@wp.kernel(module="unique", enable_backward=False)
def stacked_kernel(values: wp.array[float], places: wp.array[int]) -> None:
    """It has a list that it looks into by places that a compiler cannot know."""
    kept = wp.zeros(shape=SIZE, dtype=float)
    for index in range(SIZE):
        kept[(index * places[1]) % SIZE] = values[index]
    values[wp.tid()] = kept[places[0]]


def test_registers_stack_and_code_of_a_kernel_are_told() -> None:
    (plain,), (stacked,) = compiled(plain_kernel.module), compiled(stacked_kernel.module)
    assert plain.kernel.startswith("plain_kernel")
    assert 0 < plain.registers <= 64
    assert plain.stack < 4 * SIZE <= stacked.stack
    assert 0 < plain.code < stacked.code
