"""The service against its own description: what schemathesis makes of it is answered as it says, and never by a 500."""

from collections.abc import Iterator

import pytest
import schemathesis
from harness import Running, run
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
    unsupported_method,
)

from server.app import create_app
from server.http.security import HEADERS
from server.settings import ServerSettings

CHECKS = (
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    unsupported_method,
)


SETTINGS = ServerSettings(port=0, max_pixels=4096, max_samples=4, max_jobs=100)
IDS = ("", "", "cornell-box", "none")  # in place of made ones


@pytest.fixture(scope="module")
def service() -> Iterator[Running]:
    """A ready service that takes little at once."""
    with run(SETTINGS) as running:
        running.wait_ready()
        yield running


INTERFACE = schemathesis.openapi.from_dict(create_app(SETTINGS).openapi())
OPERATIONS = {found.ok().label: found.ok() for found in INTERFACE.get_all_operations()}


def requests_of(label: str) -> st.SearchStrategy[schemathesis.Case]:
    """Requests that the description allows; where it forbids any, those as well."""
    operation = OPERATIONS[label]
    allowed = operation.as_strategy()
    if operation.body or operation.query:
        return allowed | operation.as_strategy(generation_mode=schemathesis.GenerationMode.NEGATIVE)
    return allowed


@pytest.mark.parametrize("label", OPERATIONS)
def test_every_operation_keeps_to_its_description(label: str, service: Running) -> None:
    @settings(
        max_examples=10,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(requests_of(label), st.sampled_from(IDS))
    def ask(case: schemathesis.Case, known: str) -> None:
        for name in case.path_parameters or {}:
            if known:
                case.path_parameters[name] = known
        response = case.call(base_url=str(service.http.base_url), timeout=20)
        case.validate_response(response, checks=CHECKS)
        assert {name: response.headers.get(name.lower()) for name in HEADERS} == {
            name: [it] for name, it in HEADERS.items()
        }
        if response.status_code >= 400 and case.path != "/readyz":
            assert response.json().keys() == {"code", "message"}

    ask()


def test_all_operations_are_asked() -> None:
    assert len(OPERATIONS) == 23
