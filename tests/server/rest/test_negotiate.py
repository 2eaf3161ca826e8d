import pytest

from server.refusals import NotAcceptableError
from server.rest.negotiate import choose_format


@pytest.mark.parametrize(
    ("accept", "output"),
    [
        (None, ".png"),
        ("", ".png"),
        ("*/*", ".png"),
        ("image/*", ".png"),
        ("image/jpeg", ".jpg"),
        ("IMAGE/X-EXR", ".exr"),
        ("application/x-npy", ".npy"),
        ("application/*", ".npy"),
        ("image/png;q=0.5, image/jpeg;q=0.8", ".jpg"),
        ("image/png;q=0, */*", ".jpg"),
        ("text/html, image/x-exr;q=0.1", ".exr"),
    ],
)
def test_the_format_that_the_client_likes_best(accept: str | None, output: str) -> None:
    assert choose_format(accept)[1] == output


@pytest.mark.parametrize("accept", ["text/html", "image/webp", "image/png;q=0", "image/png;q=much"])
def test_no_format_is_an_error_that_names_those_there_are(accept: str) -> None:
    with pytest.raises(NotAcceptableError, match="image/png, image/jpeg"):
        choose_format(accept)
