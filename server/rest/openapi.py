"""The description of the REST interface (https://spec.openapis.org/oas/v3.1.0), made once from the endpoints."""

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from server.http.security import Key
from server.settings import COUNTS, ServerSettings


def describe(app: FastAPI, settings: ServerSettings) -> dict[str, Any]:
    """The description, with how a client shows that it may come in; where no token is needed, it need not."""
    if app.openapi_schema is None:
        document = get_openapi(
            title=app.title, version=app.version, description=app.description, routes=app.routes, servers=app.servers
        )
        token = settings.token
        schemes: dict[str, Any] = {"token": {"type": "http", "scheme": "bearer"}}
        if token is not None:
            cookie = Key(token.get_secret_value()).cookie
            schemes["cookie"] = {"type": "apiKey", "in": "cookie", "name": cookie, "description": "of a browser"}
        document.setdefault("components", {})["securitySchemes"] = schemes
        document["security"] = [{name: []} for name in schemes] if token is not None else [{}, {"token": []}]
        _limit(document["components"]["schemas"], settings)
        app.openapi_schema = document
    return app.openapi_schema


def _limit(schemas: dict[str, Any], settings: ServerSettings) -> None:
    """Say of counts, in the schemas, what this server gives at the most."""
    for name in COUNTS:
        for kind in schemas["RenderSettings"]["properties"][name]["anyOf"]:
            if kind["type"] == "integer":
                kind["maximum"] = min(kind["maximum"], getattr(settings, f"max_{name}"))
