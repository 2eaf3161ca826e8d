"""What is measured: a scene at a size, with the pictures that its renders are compared with."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.builtin import BUILTIN
from gpu.scene.load import load_scene
from gpu.scene.types import Camera, Floats, Scene
from gpu.settings import Component, Method, RenderSettings
from tests.bench.timing import load_kernels

Size = tuple[int, int]


@dataclass(frozen=True)
class Reference:
    """A path-traced picture of Lambertian surfaces; noise: what its relMSE owes to its own samples, 0 if not known."""

    image: Floats
    noise: float


@dataclass(frozen=True)
class Exact:
    """A picture by `exact-vpl`, and the time [ms] of the only frame it was rendered in."""

    image: Floats
    ms: float


class Subject:
    """A scene on the device at one size; its references are made once and kept in the folder `cache`.

    images: an .npz of that size with arrays `full` and `direct`, or None: then `samples` paths a pixel make them.
    """

    def __init__(
        self, name: str, scene: Scene, size: Size, device: str | None, images: Path | None, cache: Path, samples: int
    ) -> None:
        self.name, self._images, self._cache, self._samples = name, images, cache, samples
        self.device_scene = DeviceScene(scene, device)
        self.size = size
        self._references: dict[Component, Reference] = {}
        self._exact: dict[RenderSettings, Exact] = {}

    @property
    def camera(self) -> Camera:
        """The scene's first camera."""
        return self.device_scene.scene.cameras[0]

    def accumulation(self) -> Accumulation:
        """The mean of no frames yet, of this size."""
        return Accumulation(self.size[0] * self.size[1], self.device_scene.device)

    def render(self, settings: RenderSettings) -> Floats:
        """One frame from the camera."""
        return Renderer(self.device_scene, self.size, settings).render(self.camera).radiance()

    def reference(self, component: Component) -> Reference:
        """The path-traced picture of `component`."""
        if component not in self._references:
            self._references[component] = self._read(component) if self._images else self._trace(component)
        return self._references[component]

    def exact(self, settings: RenderSettings) -> Exact:
        """The lights of `settings`, each VPL with a shadow ray from every pixel and a disk as its cluster has it."""
        fields = ("component", "lambertian", "vpls", "vpl_clusters", "near_field", "seed")
        lights = settings.model_dump(include=set(fields))
        choice = RenderSettings(method=Method.EXACT_VPL, **lights)
        if choice not in self._exact:
            commit = os.environ.get("COMMIT")
            what = "-".join(str(lights[name]) for name in fields)
            made = self._kept(f"exact-{what}-{commit}", lambda: self._render_exact(choice), keep=bool(commit))
            self._exact[choice] = Exact(made["image"], float(made["ms"]))
        return self._exact[choice]

    def spread_reference(self, trace: Callable[[int], Floats]) -> Floats:
        """All light, rays spread over the pixel: `full_aa` of the reference file, or what `trace`(samples) makes."""
        if self._images:
            with np.load(self._images) as arrays:
                if "full_aa" in arrays:
                    return np.asarray(arrays["full_aa"], np.float32)
        what = f"spread-{self._samples}"
        return np.asarray(self._kept(what, lambda: {"image": trace(self._samples)}, keep=True)["image"])

    def _render_exact(self, settings: RenderSettings) -> dict[str, np.ndarray]:
        load_kernels(self.device_scene, settings)
        frame = Renderer(self.device_scene, self.size, settings).render(self.camera)
        return {"image": frame.radiance(), "ms": np.array(sum(frame.stats.stage_ms.values()))}

    def _read(self, component: Component) -> Reference:
        assert self._images is not None
        with np.load(self._images) as arrays:
            full, direct = arrays["full"].astype(np.float32), arrays["direct"].astype(np.float32)
        picture = {Component.FULL: full, Component.DIRECT: direct, Component.INDIRECT: full - direct}[component]
        return Reference(picture, 0.0)

    def _trace(self, component: Component) -> Reference:
        """The mean of two pictures with other random numbers; their difference tells the noise."""

        def make() -> dict[str, np.ndarray]:
            settings = [
                RenderSettings(
                    method=Method.PATH, component=component, lambertian=True, samples=self._samples // 2, seed=seed
                )
                for seed in (101, 202)
            ]
            one, other = (self.render(half).astype(np.float64) for half in settings)
            mean = (one + other) / 2.0
            weight = 1.0 / (mean**2 + 0.01 * np.mean(mean) ** 2)
            return {"image": mean.astype(np.float32), "noise": np.array(np.mean((one - other) ** 2 / 4.0 * weight))}

        made = self._kept(f"path-{component.value}-{self._samples}", make, keep=True)
        return Reference(made["image"], float(made["noise"]))

    def _kept(self, what: str, make: Callable[[], dict[str, np.ndarray]], *, keep: bool) -> dict[str, np.ndarray]:
        """What `make` makes, or made in an earlier run of the same scene and view."""
        path = self._cache / f"{self.name}-{self.size[0]}x{self.size[1]}-{what}-{digest(self.device_scene.scene)}.npz"
        if keep and path.exists():
            with np.load(path) as arrays:
                return dict(arrays)
        made = make()
        if keep:
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savez_compressed(path, **made)
        return made


def digest(scene: Scene) -> str:
    """Some letters that differ between scenes, or views of them, that look different."""
    total = sha256()
    for array in (scene.vertices, scene.triangles, scene.triangle_material, scene.cameras[0].to_world):
        total.update(np.ascontiguousarray(array).tobytes())
    for texture in scene.textures:
        total.update(texture.pixels.tobytes())
    total.update(repr((scene.materials, scene.lights, scene.sky, scene.cameras[0].half_height)).encode())
    return total.hexdigest()[:12]


def reference_size(images: Path) -> Size:
    """Width and height of a reference file's pictures. Raises UserError when it has none."""
    with np.load(images) as arrays:
        if not {"full", "direct"} <= set(arrays):
            raise UserError(f"{images}: a reference needs arrays `full` and `direct`; it has {', '.join(arrays)}")
        height, width = arrays["full"].shape[:2]
    return width, height


def load_subject(
    name: str, scenes: Path | None, images: Path | None, size: Size, device: str | None, cache: Path, samples: int
) -> Subject:
    """The scene `name` of the folder `scenes`, or built in; see Subject.

    Raises UserError when there is no such scene.
    """
    if name not in scene_names(scenes):
        raise UserError(f"{scenes or 'built-in scenes'}: has no {name!r}; there are {', '.join(scene_names(scenes))}")
    scene = load_scene(str(scenes / f"{name}.glb") if scenes else name)
    return Subject(name, scene, size, device, images, cache, samples)


def scene_names(scenes: Path | None) -> list[str]:
    """The scenes of the folder, or the built-in ones."""
    return sorted(path.stem for path in scenes.glob("*.glb")) if scenes else sorted(BUILTIN)
