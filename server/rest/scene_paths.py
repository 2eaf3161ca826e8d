"""Scenes in addresses: an id has slashes of its own and whatever a file may be called, line breaks too.

Below a scene are `load`, `unload` and `export.glb`, which are no part of an id: so what can be done with each is told
of it, and not of a scene that would be called so.
"""

import re

from starlette.convertors import PathConvertor, register_url_convertor

from server.scenes.uploads import EXPORT

BELOW = ("/load", "/unload", EXPORT)


class _Any(PathConvertor):
    regex = "(?s:.*)"


class _SceneAlone(PathConvertor):
    regex = rf"(?!(?s:.*)(?:{'|'.join(map(re.escape, BELOW))})\Z)(?s:.*)"


register_url_convertor("scene", _SceneAlone())
register_url_convertor("above", _Any())
SCENE = "/{scene_id:scene}"
ABOVE = "/{scene_id:above}"  # what the addresses of those below a scene begin with
