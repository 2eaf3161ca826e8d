"""A small glTF file in which everything moves, and one in which nothing does but all is where it is at a time."""

from pathlib import Path
from typing import Any

import numpy as np
from gltf_file import TRIANGLE, GltfFile

SECONDS = 2.0
HALF = float(np.float32(np.sqrt(0.5)))
UP = {"NORMAL": np.tile(np.float32([[0, 0, 1]]), (3, 1))}
LAMP = {"extensions": {"KHR_lights_punctual": {"light": 0}}}
# What nodes have at the beginning, half-way and at the end.
KEYS: dict[str, tuple[str, list[list[float]]]] = {
    "arm": ("translation", [[0, 0, 0], [0.25, 0.5, 0], [1, 0, 0]]),
    "hand": ("rotation", [[0, 0, 0, 1], [0, 0, HALF, HALF], [0, 0, 1, 0]]),
    "flat": ("scale", [[1, 1, 1], [2, 0.5, 1], [0, 0, 0]]),
    "joint": ("translation", [[0, 0, 0], [0, 1.5, 0], [0, 0, 1]]),
    "face": ("weights", [[0, 0], [0.5, 0.25], [1, 1]]),
}


def moving(folder: Path, time: float | None = None) -> GltfFile:
    """A room of 8 m with an arm that has a hand, a lamp and a camera on it, a flat thing, a skin and a morph.

    time: of 0, 1 and 2 s, at which all is in a file without animation; None: a file with one, whose pose is that at 0.
    """
    gltf = GltfFile(folder)
    corners = np.float32([[-4, -4, -4], [4, 4, 4], [4, -4, 4]])
    gltf.mesh_node(gltf.primitive(corners), name="room")
    nodes = {}
    key = 0 if time is None else int(time)
    said: dict[str, dict[str, Any]] = {name: {what: values[key]} for name, (what, values) in KEYS.items()}
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "name": "lamp"}]}}
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0})
    nodes["lamp"] = gltf.add("nodes", translation=[0, 2, 0], camera=0, **LAMP)
    nodes["hand"] = gltf.mesh_node(gltf.primitive(**UP), name="hand", children=[nodes["lamp"]], **said["hand"])
    nodes["arm"] = gltf.mesh_node(name="arm", children=[nodes["hand"]], **said["arm"])
    nodes["flat"] = gltf.mesh_node(gltf.primitive(TRIANGLE - 1), name="flat", **said["flat"])
    nodes["joint"], root = gltf.add("nodes", **said["joint"]), gltf.add("nodes", translation=[-1, 0, 0])
    shares = np.float32([[1, 0, 0, 0], [0.5, 0.5, 0, 0], [0, 1, 0, 0]])
    bound = {"JOINTS_0": np.uint8([[0, 1, 0, 0]] * 3), "WEIGHTS_0": shares}
    gltf.add("skins", joints=[nodes["joint"], root])
    gltf.mesh_node(gltf.primitive(**bound, **UP), name="skinned", skin=0)
    shifts = [(TRIANGLE * [1, 2, 0] + [0, 0, at], np.tile([[at, 1.0, 0.0]], (3, 1))) for at in (1, 2)]
    targets = [{"POSITION": gltf.accessor(where), "NORMAL": gltf.accessor(turn)} for where, turn in shifts]
    nodes["face"] = gltf.mesh_node(gltf.primitive(targets=targets, **UP), name="face", **said["face"])
    if time is None:
        times = gltf.accessor(np.float32([0, 1, SECONDS]))
        samplers = [{"input": times, "output": gltf.accessor(_rows(*KEYS[name]))} for name in KEYS]
        channels = [
            {"sampler": number, "target": {"node": nodes[name], "path": KEYS[name][0]}}
            for number, name in enumerate(KEYS)
        ]
        gltf.json["animations"] = [{"name": "wave", "samplers": samplers, "channels": channels}]
    gltf.add("scenes", nodes=[n for n in range(len(gltf.json["nodes"])) if n not in (nodes["hand"], nodes["lamp"])])
    return gltf


def _rows(what: str, values: list[list[float]]) -> np.ndarray:
    rows = np.float32(values)
    return rows.reshape(-1) if what == "weights" else rows
