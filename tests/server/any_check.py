"""A checker for services with a gradient worker: every file is a sound scene, without a look into it."""

import sys

from server.scenes.checker import Checked, CheckRequest, SceneSize
from server.wire.browser import Bounds, SceneInfo

request = CheckRequest.model_validate_json(sys.stdin.buffer.read())
bounds = Bounds(min=(0.0, 0.0, 0.0), max=(1.0, 1.0, 1.0))
info = SceneInfo(id=request.source, name="", cameras=(), bounds=bounds, options=request.options, triangles=12)
size = SceneSize(vertices=24, triangles=12, uv_sets=0, colored=False, materials=1, texels=0)
sys.stdout.write(Checked(source=request.source, info=info, size=size).model_dump_json())
