"""/api/docs: the REST interface to read and try out (Swagger UI), with nothing loaded from elsewhere."""

from importlib.resources import files

from fastapi import APIRouter
from starlette.responses import HTMLResponse, Response
from starlette.staticfiles import StaticFiles

# The script is a file of its own because the Content-Security-Policy allows none inside a page.
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>lumenwalk: REST</title>
<link rel="stylesheet" href="/api/docs/files/swagger-ui.css"></head>
<body><div id="docs"></div>
<script src="/api/docs/files/swagger-ui-bundle.js"></script><script src="/api/docs/start.js"></script></body></html>
"""
START = """SwaggerUIBundle({ url: "/api/openapi.json", dom_id: "#docs", deepLinking: true, validatorUrl: null });"""

router = APIRouter(include_in_schema=False)
swagger = StaticFiles(directory=str(files("fastapi_swagger.resources")))


@router.get("/api/docs")
async def page() -> HTMLResponse:
    """The page."""
    return HTMLResponse(PAGE)


@router.get("/api/docs/start.js")
async def start() -> Response:
    """Its script."""
    return Response(START, media_type="text/javascript")
