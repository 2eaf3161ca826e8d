"""A checker for services with a gradient worker: every file is a sound scene, without a look into it.

It starts in no time: nothing of the service is loaded.
"""

import json
import sys

request = json.load(sys.stdin)
bounds = {"min": (0.0, 0.0, 0.0), "max": (1.0, 1.0, 1.0)}
matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
camera = {"name": "front", "matrix": matrix, "yfov": 1.0, "aspect": 1.5, "orthographic": False, "near": 0.0}
info = {"id": request["source"], "name": "", "cameras": (camera,), "bounds": bounds, "options": request["options"]}
size = {"vertices": 24, "triangles": 12, "uv_sets": 0, "colored": False, "materials": 1, "texels": 0}
json.dump({"source": request["source"], "info": info | {"triangles": 12}, "size": size}, sys.stdout)
