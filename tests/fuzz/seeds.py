"""Small sound scene files of every format, for mutations to start from; here those that the project reads itself."""

import base64
import json
import struct
import tempfile
from pathlib import Path

import numpy as np
from gltf_file import TRIANGLE, UV, GltfFile, image

from tests.fuzz.seed import Seed
from tests.fuzz.seeds_of_libraries import more_seeds


def seeds() -> list[Seed]:
    """All of them, the same each time but for those that libraries write."""
    glb = _glb()
    ply, binary_ply = _ply()
    mtl = b"""newmtl red
Kd 0.8 0.1 0.1
Ke 0 0 0.5
Ns 30
Pr 0.4
map_Kd -o 0.5 0 -s 2 2 -clamp on red.png
newmtl glass
Tf 0.5 0.5 0.5
d 0.5
illum 7
Ni 1.5
"""
    return [
        Seed("scene.glb", glb),
        Seed("scene.gltf", _gltf(glb)),
        Seed("scene.obj", _OBJ, {"scene.mtl": mtl, "red.png": _png()}),
        Seed("scene.stl", _STL),
        Seed("binary.stl", _binary_stl()),
        Seed("scene.ply", ply),
        Seed("binary.ply", binary_ply),
        Seed(
            "scene.off",
            b"COFF\n4 2 0\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n0 1 0 0 0 1 1\n0 0 1 1 1 1 1\n3 0 1 2 255 0 0\n3 0 1 3\n",
        ),
        Seed("binary.off", _binary_off()),
        *more_seeds(),
    ]


_OBJ = b"""mtllib scene.mtl
o box
v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
g front
usemtl red
s 1
f 1/1/1 2/2/1 3/3/1 4/1/1
usemtl glass
f -4//-1 -3//-1 -1//-1
f 1 2 \\
3
l 1 2
"""
_STL = b"""solid box
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
facet normal 0 1 0
outer loop
vertex 0 0 0
vertex 0 0 1e0
vertex 1 0 0
endloop
endfacet
endsolid box
"""


def _glb() -> bytes:
    """Of most kinds of things that a glTF file can have."""
    with tempfile.TemporaryDirectory() as folder:
        gltf = GltfFile(Path(folder))
        gltf.json["extensionsUsed"] = ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_variants"]
        gltf.add("samplers", magFilter=9729, wrapS=33071)
        gltf.add("textures", source=image(gltf), sampler=0)
        transform = {"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 0.3, "scale": [2, 2]}}
        gltf.add(
            "materials",
            pbrMetallicRoughness={
                "baseColorTexture": {"index": 0, "extensions": transform},
                "baseColorFactor": [1, 0.5, 0.5, 1],
                "metallicFactor": 0.5,
            },
            emissiveFactor=[0, 0, 1],
            alphaMode="MASK",
            alphaCutoff=0.5,
            doubleSided=True,
            extensions={
                "KHR_materials_transmission": {"transmissionFactor": 0.5},
                "KHR_materials_ior": {"ior": 1.4},
                "KHR_materials_emissive_strength": {"emissiveStrength": 2.0},
            },
        )
        gltf.add("materials", extensions={"KHR_materials_unlit": {}}, alphaMode="BLEND")
        variants = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
        normals = np.tile(np.float32([0, 0, 1]), (3, 1))
        first = gltf.primitive(
            indices=[0, 1, 2], material=0, extensions=variants, NORMAL=normals, TEXCOORD_0=UV, COLOR_0=np.ones((3, 4))
        )
        delta = gltf.accessor(TRIANGLE * 0.1)
        first["targets"] = [{"POSITION": delta}]
        strip = gltf.primitive(np.vstack([TRIANGLE, [[1, 1, 0]]]).astype(np.float32), mode=5, material=1)
        sparse = gltf.primitive()
        gltf.json["accessors"][sparse["attributes"]["POSITION"]]["sparse"] = {
            "count": 1,
            "indices": {"bufferView": gltf.view(struct.pack("<H", 1)), "componentType": 5123},
            "values": {"bufferView": gltf.view(np.float32([2, 0, 0]).tobytes())},
        }
        joints = np.zeros((3, 4), np.uint8)
        weights = np.tile(np.float32([1, 0, 0, 0]), (3, 1))
        skinned = gltf.primitive(JOINTS_0=joints, WEIGHTS_0=weights)
        gltf.add("skins", joints=[0], inverseBindMatrices=gltf.accessor(np.eye(4, dtype=np.float32).reshape(1, 16)))
        gltf.mesh_node(first, strip, mesh={"weights": [0.5]}, rotation=[0, 0, 0, 1], scale=[1, 2, 1])
        gltf.mesh_node(sparse, translation=[1, 0, 0], children=[0])
        gltf.mesh_node(skinned, skin=0)
        gltf.add("cameras", type="perspective", perspective={"yfov": 1.0, "znear": 0.1})
        gltf.add("cameras", type="orthographic", orthographic={"xmag": 1, "ymag": 1, "znear": 0, "zfar": 10})
        gltf.add("nodes", camera=0, matrix=np.eye(4).reshape(-1).tolist())
        gltf.add("nodes", camera=1, extensions={"KHR_lights_punctual": {"light": 0}}, name="lamp")
        gltf.json["extensions"] = {
            "KHR_lights_punctual": {
                "lights": [{"type": "spot", "intensity": 5, "color": [1, 1, 0], "spot": {"outerConeAngle": 0.5}}]
            },
            "KHR_materials_variants": {"variants": [{"name": "night"}]},
        }
        gltf.add("scenes", nodes=[1, 2, 3, 4], name="all")
        gltf.json["scene"] = 0
        return gltf.write().read_bytes()


def _gltf(glb: bytes) -> bytes:
    """The same as text, its buffer within."""
    (length,) = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20 : 20 + length])
    data = base64.b64encode(glb[28 + length :]).decode()
    document["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
    return json.dumps(document).encode()


def _png() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        gltf = GltfFile(Path(folder))
        image(gltf)
        return bytes(gltf.binary)


def _ply() -> tuple[bytes, bytes]:
    head = """ply
format {kind} 1.0
comment made for tests
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
element tristrips 1
property list int int vertex_indices
end_header
"""
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    rows = "".join(f"{x} {y} {z} 255 0 9\n" for x, y, z in points) + "3 0 1 2\n4 0 1 2 3\n4 0 1 2 -1\n"
    packed = b"".join(struct.pack("<3f3B", *point, 255, 0, 9) for point in points)
    packed += struct.pack("<B3iB4i", 3, 0, 1, 2, 4, 0, 1, 2, 3) + struct.pack("<i4i", 4, 0, 1, 2, -1)
    return (
        (head.format(kind="ascii") + rows).encode(),
        head.format(kind="binary_little_endian").encode() + packed,
    )


def _binary_stl() -> bytes:
    facet = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    return b"made for tests".ljust(80, b"\0") + struct.pack("<I", 2) + facet + facet


def _binary_off() -> bytes:
    content = struct.pack(">3i", 3, 1, 0) + np.array(TRIANGLE, ">f4").tobytes()
    return b"OFF BINARY\n" + content + struct.pack(">4i", 3, 0, 1, 2) + struct.pack(">i3f", 3, 1, 0, 0)
