from tests.bench.kernels import in_sum, typical


def test_launches_of_a_kernel_are_summed() -> None:
    assert in_sum([("trace", 1.0), ("sum", 0.5), ("trace", 2.0)]) == {"trace": (3.0, 2), "sum": (0.5, 1)}


def test_the_dearest_kernel_comes_first_and_one_that_a_frame_lacks_took_nothing() -> None:
    frames = [{"sum": (0.5, 1), "trace": (3.0, 2)}, {"trace": (5.0, 3)}, {"trace": (4.0, 2)}]
    assert list(typical(frames).items()) == [("trace", (4.0, 3)), ("sum", (0.0, 1))]
