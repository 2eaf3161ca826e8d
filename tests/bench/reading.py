"""How long a bare mesh takes to read: `python -m tests.bench.reading [TRIANGLES …]`, of 200,000 and a million if none.

Processor time of one core, the least of a few readings, from the file to a scene in unit space with its normals, a
chosen view and a light.
"""

import struct
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from gpu.scene.load import load_scene

COUNTS = (200_000, 1_000_000)
REPEATS = 3
_HEADER = """ply
format binary_little_endian 1.0
element vertex {}
property float x
property float y
property float z
element face {}
property list uchar int vertex_indices
end_header
"""


def write_meshes(folder: Path, triangles: int) -> tuple[Path, Path]:
    """Binary PLY and STL files of a wavy ground of about as many triangles."""
    side = max(int(np.sqrt(triangles / 2)), 1)
    x, z = np.meshgrid(np.linspace(0.0, 10.0, side + 1), np.linspace(0.0, 10.0, side + 1), indexing="ij")
    vertices = np.stack([x, np.sin(3.0 * x) * np.cos(2.0 * z), z], axis=-1).reshape(-1, 3).astype("<f4")
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    halves = (first, first + 1, first + side + 2), (first, first + side + 2, first + side + 1)
    faces = np.concatenate([np.stack(half, axis=1) for half in halves])
    lists = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    lists["count"], lists["corners"] = 3, faces
    ply, stl = folder / f"{triangles}.ply", folder / f"{triangles}.stl"
    ply.write_bytes(_HEADER.format(len(vertices), len(faces)).encode() + vertices.tobytes() + lists.tobytes())
    facets = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    facets["corners"] = vertices[faces]
    stl.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + facets.tobytes())
    return ply, stl


def seconds(path: Path) -> float:
    """Processor time that reading the scene at `path` takes [s]."""
    taken = []
    for _ in range(REPEATS):
        begun = process_time()
        load_scene(str(path))
        taken.append(process_time() - begun)
    return min(taken)


if __name__ == "__main__":
    with TemporaryDirectory() as temporary:
        for wanted in [int(count) for count in sys.argv[1:]] or COUNTS:
            for file in write_meshes(Path(temporary), wanted):
                print(f"{file.name:12} {seconds(file):6.2f} s")
