import numpy as np

from gpu.scene.floats import doubles, triple


def test_numbers_stay_and_a_signalling_nan_is_a_nan() -> None:
    read = doubles(np.array([0x3F800000, 0x7F800001, 0x7F800000], np.uint32).view(np.float32))
    assert read[0] == 1.0
    assert np.isnan(read[1])
    assert np.isinf(read[2])
    assert doubles(np.array([3], np.uint8)).tolist() == [3.0]


def test_three_numbers_are_plain_floats() -> None:
    assert triple(np.array([1, 2, 3], np.float32)) == (1.0, 2.0, 3.0)
    assert {type(value) for value in triple(np.arange(3))} == {float}
