import pytest

from gpu.scene.lengths import length_text


@pytest.mark.parametrize(
    ("metres", "words"),
    [
        (460_123.0, "460 km"),
        (1e33, "1e+30 km"),
        (2000.0, "2 km"),
        (3.21, "3.2 m"),
        (0.032, "3.2 cm"),
        (0.0071, "7.1 mm"),
        (5e-5, "0.05 mm"),
    ],
)
def test_lengths_in_words(metres: float, words: str) -> None:
    assert length_text(metres) == words
