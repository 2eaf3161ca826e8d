import pytest

from gpu.errors import UserError
from tests.load.target import target_at


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.9.1", "localhost", "[::1]"])
def test_services_of_this_machine_are_loaded(host: str) -> None:
    assert target_at(f"http://{host}:81/?x", None, remote=False).url == f"http://{host}:81"


def test_a_service_below_a_path_is_loaded_there() -> None:
    target = target_at("http://127.0.0.1:81/r/0/", None, remote=False)
    assert target.url == "http://127.0.0.1:81/r/0"
    assert target.socket().uri == "ws://127.0.0.1:81/r/0/api/v1/stream"


@pytest.mark.parametrize("host", ["example.org", "10.0.0.1", "0.0.0.0", "127.0.0.1.example.org"])
def test_other_machines_are_loaded_only_when_told(host: str) -> None:
    with pytest.raises(UserError, match="--remote"):
        target_at(f"http://{host}/", None, remote=False)
    assert target_at(f"http://{host}/", None, remote=True).address == (host, 80)


@pytest.mark.parametrize("url", ["127.0.0.1:8000", "ws://127.0.0.1", "file:///x"])
def test_what_is_no_address_of_a_service_is_refused(url: str) -> None:
    with pytest.raises(UserError, match="must be the address"):
        target_at(url, None, remote=True)
