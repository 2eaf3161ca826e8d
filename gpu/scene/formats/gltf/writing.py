"""A scene as a GLB file (glTF 2.0, section 4.4), in metres with +Y up.

What glTF has no words for stays out: skies, and motion, since a scene is written as it is at its moment.
"""

import io
import json
import struct
from collections.abc import Iterator
from dataclasses import replace
from math import acos, atan
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from gpu.scene.formats.gltf.written_materials import back_of, material_entry
from gpu.scene.types import Camera, Doubles, Light, LightKind, Scene, Texture, Wrap

_FLOAT, _UINT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_WRAPS = {Wrap.REPEAT: 10497, Wrap.CLAMP: 33071, Wrap.MIRROR: 33648}
_NEAREST, _LINEAR = 9728, 9729
_KINDS = {LightKind.POINT: "point", LightKind.SPOT: "spot", LightKind.DIRECTIONAL: "directional"}
_LEAST_NEAR = 1e-3  # of a perspective camera [m], which must have some


def glb_of(scene: Scene) -> bytes:
    """The file: a node an object, with its place in world space; lights, materials and textures as they are now."""
    return _Writer(scene).file()


class _Writer:
    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._binary = bytearray()
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        backs = {number: back for number, it in enumerate(scene.materials) if (back := back_of(it))}
        self._backs = {number: len(scene.materials) + place for place, number in enumerate(backs)}
        self._materials = [*scene.materials, *backs.values()]

    def file(self) -> bytes:
        scene = self._scene
        meshes = list(self._meshes())
        # Positions count from the middle of the scene, so that those far from the world's origin stay exact.
        nodes: list[dict[str, Any]] = [{"translation": list(scene.placement.centre), "children": []}]
        nodes += [{"name": mesh["name"], "mesh": number} for number, mesh in enumerate(meshes)]
        nodes[0]["children"] = list(range(1, len(nodes)))
        lights = [_light_entry(light, scene.placement.scale) for light in scene.lights]
        roots = [0, *range(len(nodes), len(nodes) + len(lights) + len(scene.cameras))]
        for number, light in enumerate(scene.lights):
            place = _light_matrix(light, scene)
            reference = {"KHR_lights_punctual": {"light": number}}
            nodes.append({"name": light.name, "matrix": place.T.ravel().tolist(), "extensions": reference})
        for number, camera in enumerate(scene.cameras):
            place = camera.to_world.copy()
            place[:3, :3] /= np.linalg.norm(place[:3, :3], axis=0)
            nodes.append({"name": camera.name, "matrix": place.T.ravel().tolist(), "camera": number})
        factor = scene.frame.metres_per_unit
        materials = [
            material_entry(
                replace(it, thickness=it.thickness * factor, attenuation_distance=it.attenuation_distance * factor)
            )
            for it in self._materials
        ]
        document = {
            "asset": {"version": "2.0", "generator": "lumenwalk"},
            "scene": 0,
            "scenes": [{"nodes": roots}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
            "cameras": [_camera_entry(camera) for camera in scene.cameras],
            **self._texture_parts(),
            "extensions": {"KHR_lights_punctual": {"lights": lights}} if lights else {},
        }
        used = {name for part in (*materials, *nodes, document) for name in part.get("extensions", ())}
        slots = (slot for part in materials for slot in _texture_infos(part) if "extensions" in slot)
        document["extensionsUsed"] = sorted(used | {name for slot in slots for name in slot["extensions"]})
        document |= {"accessors": self._accessors, "bufferViews": self._views}
        document["buffers"] = [{"byteLength": len(self._binary)}]
        return _glb({name: part for name, part in document.items() if part not in ([], {})}, bytes(self._binary))

    def _meshes(self) -> Iterator[dict[str, Any]]:
        """A mesh an object that is there, of a primitive a material, and one more where it has a back."""
        scene = self._scene
        names = scene.objects or (scene.name,)
        owner = (
            scene.vertex_object[scene.triangles[:, 0]] if scene.objects else np.zeros(len(scene.triangles), np.int32)
        )
        order = np.lexsort((scene.triangle_material, owner))
        owners, materials = owner[order], scene.triangle_material[order]
        starts = np.flatnonzero((np.diff(owners, prepend=-1) != 0) | (np.diff(materials, prepend=-1) != 0))
        mesh: dict[str, Any] | None = None
        last = -1
        for start, end in zip(starts, [*starts[1:], len(order)], strict=True):
            if mesh is None or owners[start] != last:
                if mesh is not None:
                    yield mesh
                last = int(owners[start])
                mesh = {"name": names[last], "primitives": []}
            material, triangles = int(materials[start]), scene.triangles[order[start:end]]
            mesh["primitives"].append(self._primitive(triangles, material))
            if material in self._backs:
                mesh["primitives"].append(self._primitive(triangles[:, ::-1], self._backs[material], side=-1.0))
        if mesh is not None:
            yield mesh

    def _primitive(self, triangles: NDArray[np.int32], material: int, side: float = 1.0) -> dict[str, Any]:
        scene = self._scene
        used, indices = np.unique(triangles, return_inverse=True)
        positions = (scene.vertices[used].astype(np.float64) / scene.placement.scale).astype(np.float32)
        box = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
        attributes = {
            "POSITION": self._accessor(positions, "VEC3", box),
            "NORMAL": self._accessor(np.float32(side) * scene.normals[used], "VEC3"),
        }
        for number, uvs in enumerate(scene.uvs):
            attributes[f"TEXCOORD_{number}"] = self._accessor(uvs[used], "VEC2")
        if scene.colors is not None:
            attributes["COLOR_0"] = self._accessor(scene.colors[used], "VEC4")
        listed = self._accessor(indices.ravel().astype(np.uint32), "SCALAR")
        return {"attributes": attributes, "indices": listed, "material": material}

    def _accessor(self, values: NDArray[Any], kind: str, box: dict[str, Any] | None = None) -> int:
        is_index = values.dtype == np.uint32
        view = self._view(np.ascontiguousarray(values).tobytes(), _INDICES if is_index else _VERTICES)
        component = _UINT if is_index else _FLOAT
        self._accessors.append(
            {"bufferView": view, "componentType": component, "count": len(values), "type": kind, **(box or {})}
        )
        return len(self._accessors) - 1

    def _view(self, content: bytes, target: int | None = None) -> int:
        self._binary += b"\0" * (-len(self._binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(content)}
        self._views.append(view if target is None else {**view, "target": target})
        self._binary += content
        return len(self._views) - 1

    def _texture_parts(self) -> dict[str, Any]:
        """Images, samplers and textures; equal pixels are written once."""
        images: list[dict[str, Any]] = []
        known: dict[int, int] = {}
        for texture in self._scene.textures:
            if id(texture.pixels) not in known:
                known[id(texture.pixels)] = len(images)
                images.append({"bufferView": self._view(_png(texture)), "mimeType": "image/png"})
        textures = [
            {"name": it.name, "source": known[id(it.pixels)], "sampler": n} for n, it in enumerate(self._scene.textures)
        ]
        samplers = [
            {
                "wrapS": _WRAPS[it.wrap_s],
                "wrapT": _WRAPS[it.wrap_t],
                "magFilter": _NEAREST if it.nearest else _LINEAR,
                "minFilter": _NEAREST if it.nearest else _LINEAR,
            }
            for it in self._scene.textures
        ]
        return {"images": images, "textures": textures, "samplers": samplers}


def _texture_infos(part: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """All uses of textures within a material."""
    for name, value in part.items():
        if isinstance(value, dict):
            if name.endswith("Texture"):
                yield value
            yield from _texture_infos(value)


def _png(texture: Texture) -> bytes:
    file = io.BytesIO()
    Image.fromarray(texture.pixels).save(file, "PNG", compress_level=1)
    return file.getvalue()


def _light_entry(light: Light, scale: float) -> dict[str, Any]:
    """In world space: distances grow by 1 / scale, so intensity by its square."""
    factor = 1.0 if light.kind is LightKind.DIRECTIONAL else scale**-2
    most = max(light.intensity)
    color = [value / most for value in light.intensity] if most > 0.0 else [1.0, 1.0, 1.0]
    entry = {"name": light.name, "type": _KINDS[light.kind], "color": color, "intensity": most * factor}
    if light.kind is LightKind.SPOT:
        inner, outer = (acos(min(max(cosine, 0.0), 1.0)) for cosine in (light.cos_inner, light.cos_outer))
        entry["spot"] = {"innerConeAngle": inner, "outerConeAngle": outer}
    return entry


def _light_matrix(light: Light, scene: Scene) -> Doubles:
    """Where it is, looking along −Z."""
    back = -np.array(light.direction) / np.linalg.norm(light.direction)
    across = np.cross((0.0, 1.0, 0.0) if abs(back[1]) < 0.9 else (1.0, 0.0, 0.0), back)
    across /= np.linalg.norm(across)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([across, np.cross(back, across), back], axis=1)
    matrix[:3, 3] = np.array(light.position) / scene.placement.scale + scene.placement.centre
    return matrix


def _camera_entry(camera: Camera) -> dict[str, Any]:
    if camera.orthographic:
        size = {"xmag": camera.half_height * camera.aspect, "ymag": camera.half_height}
        return {
            "name": camera.name,
            "type": "orthographic",
            "orthographic": {**size, "znear": camera.near, "zfar": 1e6},
        }
    lens = {"yfov": 2.0 * atan(camera.half_height), "aspectRatio": camera.aspect, "znear": camera.near or _LEAST_NEAR}
    return {"name": camera.name, "type": "perspective", "perspective": lens}


def _glb(document: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
