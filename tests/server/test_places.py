import pytest

from server.places import Places
from server.refusals import TooBusyError


def test_one_client_has_some_and_all_have_more() -> None:
    places = Places("streams", 2, 1)
    with places.taken("a"):
        with pytest.raises(TooBusyError, match="too many streams"), places.taken("a"):
            pass
        with places.taken("b"), pytest.raises(TooBusyError), places.taken("c"):
            pass
        with places.taken("c"):
            pass
    with places.taken("a"):
        pass
