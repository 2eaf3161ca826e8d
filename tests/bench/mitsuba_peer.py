"""The same scene in Mitsuba 3, as Lambertian surfaces: a path tracer by others to compare with. Optional dependency.

Rays are spread over the pixel, as its path tracer does; compare with pictures made likewise.
"""

from math import acos, atan, degrees
from time import perf_counter
from typing import Any

import numpy as np

from gpu.scene.types import Camera, Floats, Light, LightKind, Scene, TextureSlot, Wrap
from tests.bench.subjects import Size

_WRAPS = {Wrap.REPEAT: "repeat", Wrap.CLAMP: "clamp", Wrap.MIRROR: "mirror"}


class MitsubaScene:
    """`scene` from its first camera at `size`; `bounces`: indirect bounces.

    Raises ImportError without Mitsuba. Vertex colours and alpha are left out, as in the references.
    """

    def __init__(self, scene: Scene, size: Size, bounces: int, *, cuda: bool) -> None:
        import mitsuba

        mitsuba.set_variant("cuda_ad_rgb" if cuda else "scalar_rgb")
        self._mi: Any = mitsuba
        self.version: str = mitsuba.__version__
        parts = {"type": "scene", "integrator": {"type": "path", "max_depth": bounces + 2, "rr_depth": 1000}}
        parts["sensor"] = self._sensor(scene, scene.cameras[0], size)
        parts |= {f"mesh{number}": self._mesh(scene, number) for number in np.unique(scene.triangle_material)}
        parts |= {f"light{number}": self._light(light) for number, light in enumerate(scene.lights)}
        if scene.sky:
            cosine = np.cos(np.pi * (np.arange(128) + 0.5) / 128)[:, None, None]
            rows = np.broadcast_to((0.5 + 0.5 * cosine) * np.array(scene.sky.radiance), (128, 256, 3))
            parts["sky"] = {"type": "envmap", "bitmap": mitsuba.Bitmap(np.ascontiguousarray(rows, np.float32))}
        self._scene = mitsuba.load_dict(parts)

    def render(self, samples: int, seed: int) -> tuple[Floats, float]:
        """A picture with `samples` paths a pixel, and its time [ms]."""
        begun = perf_counter()
        image = np.array(self._mi.render(self._scene, spp=samples, seed=seed), np.float32)
        return image, 1e3 * (perf_counter() - begun)

    def _sensor(self, scene: Scene, camera: Camera, size: Size) -> dict[str, Any]:
        place = camera.to_world.copy()
        place[:3, 3] = (place[:3, 3] - scene.placement.centre) * scene.placement.scale
        return {
            "type": "perspective",
            "fov": 2.0 * degrees(atan(camera.half_height)),
            "fov_axis": "y",
            "to_world": self._mi.ScalarTransform4f((place @ np.diag([-1.0, 1.0, -1.0, 1.0])).tolist()),
            "near_clip": 1e-4,
            "far_clip": 1e2,
            "film": {
                "type": "hdrfilm",
                "width": size[0],
                "height": size[1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
            },
            "sampler": {"type": "independent"},
        }

    def _mesh(self, scene: Scene, number: int) -> Any:
        """The triangles of one material."""
        mi, material = self._mi, scene.materials[number]
        used, faces = np.unique(scene.triangles[scene.triangle_material == number], return_inverse=True)
        slot = material.base_color_slot
        properties = mi.Properties()
        reflectance = self._colour(scene, slot, np.array(material.base_color[:3]))
        diffuse = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
        properties["bsdf"] = mi.load_dict(diffuse)
        if any(material.emission):
            radiance = {"type": "rgb", "value": list(material.emission)}
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance})
        mesh = mi.Mesh(f"mesh{number}", len(used), faces.size // 3, has_vertex_texcoords=bool(slot), props=properties)
        values = mi.traverse(mesh)
        values["vertex_positions"] = scene.vertices[used].ravel()
        values["faces"] = faces.astype(np.uint32).ravel()
        if slot:
            uvs = np.insert(scene.uvs[slot.uv_set][used], 2, 1.0, axis=1)
            values["vertex_texcoords"] = (uvs @ np.reshape(slot.transform, (2, 3)).T).astype(np.float32).ravel()
        values.update()
        return mesh

    def _colour(self, scene: Scene, slot: TextureSlot | None, factor: np.ndarray) -> dict[str, Any]:
        if slot is None:
            return {"type": "rgb", "value": factor.tolist()}
        texture = scene.textures[slot.texture]
        x = texture.pixels[..., :3] / 255.0
        linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4) if texture.srgb else x
        pixels = np.minimum(linear * factor, 1.0).astype(np.float32)
        wrap = _WRAPS[texture.wrap_s]
        return {"type": "bitmap", "bitmap": self._mi.Bitmap(pixels), "raw": True, "wrap_mode": wrap}

    def _light(self, light: Light) -> dict[str, Any]:
        value = {"type": "rgb", "value": list(light.intensity)}
        if light.kind is LightKind.DIRECTIONAL:
            return {"type": "directional", "direction": list(light.direction), "irradiance": value}
        if light.kind is LightKind.POINT:
            return {"type": "point", "position": list(light.position), "intensity": value}
        target = (np.array(light.position) + light.direction).tolist()
        place = self._mi.ScalarTransform4f().look_at(origin=list(light.position), target=target, up=[0.01, 1.0, 0.02])
        angles = {"cutoff_angle": degrees(acos(light.cos_outer)), "beam_width": degrees(acos(light.cos_inner))}
        return {"type": "spot", "to_world": place, "intensity": value, **angles}
