"""/api/docs: the REST interface to read and try out (Swagger UI), with nothing loaded from elsewhere.

What it loads is named from the page, so that it is found below any prefix. Without an icon of its own, browsers would
ask for one at the top of the host.
"""

from importlib.resources import files

from fastapi import APIRouter
from starlette.responses import HTMLResponse, Response
from starlette.staticfiles import StaticFiles

# The script is a file of its own because the Content-Security-Policy allows none inside a page.
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>lumenwalk: REST</title>
<link rel="icon" href="data:,"><link rel="stylesheet" href="docs/files/swagger-ui.css"></head>
<body><div id="docs"></div>
<script src="docs/files/swagger-ui-bundle.js"></script><script src="docs/start.js"></script></body></html>
"""
START = """SwaggerUIBundle({ url: "openapi.json", dom_id: "#docs", deepLinking: true, validatorUrl: null });"""

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
