"""Errors that must not rise: small renders of built-in scenes on the CPU against what was stored, deterministic.

    python -m tests.bench gate            compare
    python -m tests.bench gate --update   store what is rendered now, after a change that was meant to cost accuracy

gate.json holds the errors, gate.npz the path-traced references, which are rendered anew when their scene changes.
"""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.film.metrics import measure
from gpu.renderer import Renderer
from gpu.scene.load import load_scene
from gpu.scene.types import Floats, Scene
from gpu.settings import Component, Method, RenderSettings

# By scene, then by what is compared, then by metric.
Errors = dict[str, dict[str, dict[str, float]]]

STORED, REFERENCES = (Path(__file__).with_name(f"gate.{kind}") for kind in ("json", "npz"))
SCENES = ("cornell-box", "living-room", "conference-room")
SIZE = (96, 64)
COUNTS = {"sp_clusters": 300, "vpl_clusters": 100, "vpls": 1000, "samples": 1}
# The mean over a few seeds moves less when a processor rounds otherwise and a ray goes elsewhere: by up to 3 % seen.
SEEDS = 2
TOLERANCE = 0.08
REFERENCE_SAMPLES = 1024
METRICS = ("mse", "rel_mse", "flip")
ADVICE = "If that is meant: python -m tests.bench gate --update, and say in the commit why."


def signature(scene: Scene) -> list[float]:
    """Numbers that change when the scene or its first view does, and hardly with how a processor rounds."""
    camera, materials = scene.cameras[0], scene.materials
    colours = np.mean([(*material.base_color, *material.emission) for material in materials], axis=0)
    texels = [float(texture.pixels.mean()) for texture in scene.textures]
    geometry = [len(scene.triangles), *np.abs(scene.vertices).mean(axis=0), *scene.vertices.std(axis=0)]
    view = [*camera.to_world.ravel(), camera.half_height]
    return [float(number) for number in (*geometry, *view, *colours, *texels)]


def same(one: list[float] | None, other: list[float]) -> bool:
    """Whether two signatures are of one scene."""
    return one is not None and len(one) == len(other) and bool(np.allclose(one, other, rtol=1e-4, atol=1e-6))


def render(device_scene: DeviceScene, component: Component, **changes: object) -> Floats:
    """One small picture from the scene's first camera."""
    settings = RenderSettings.model_validate({"component": component, "lambertian": True, **COUNTS, **changes})
    return Renderer(device_scene, SIZE, settings).render(device_scene.scene.cameras[0]).radiance()


def measure_scene(device_scene: DeviceScene, references: dict[str, Floats]) -> dict[str, dict[str, float]]:
    """Mean errors over the seeds: indirect light against `exact-vpl` (clustering) and its reference, and all light.

    Clusters have no part in near-field light, which is left out where they are compared. nonfinite is the sum.
    references: by component.
    """
    sums: dict[str, list[dict[str, float]]] = {"clustering": [], "indirect": [], "full": []}
    for seed in range(SEEDS):
        indirect, full = (
            render(device_scene, component, seed=seed) for component in (Component.INDIRECT, Component.FULL)
        )
        clustered, exact = (
            render(device_scene, Component.INDIRECT, method=method, near_field=False, seed=seed)
            for method in (Method.FUZZY_VPL, Method.EXACT_VPL)
        )
        sums["clustering"].append(asdict(measure(clustered, exact)))
        sums["indirect"].append(asdict(measure(indirect, references["indirect"])))
        sums["full"].append(asdict(measure(full, references["full"])))
    return {
        what: {metric: float(np.mean([errors[metric] for errors in runs])) for metric in METRICS}
        | {"nonfinite": sum(errors["nonfinite"] for errors in runs)}
        for what, runs in sums.items()
    }


def complaints(now: Errors, stored: Errors) -> list[str]:
    """A line for every error that rose beyond the tolerance, that is not a number, or that was not stored."""
    lines = []
    for scene, comparisons in now.items():
        for what, errors in comparisons.items():
            before = stored.get(scene, {}).get(what, {})
            for metric, value in errors.items():
                limit = before.get(metric, -1.0) * (1.0 + TOLERANCE)
                if not value <= limit:
                    was = f"{before[metric]:.4g}" if metric in before else "not stored"
                    lines.append(f"{scene}: {what} {metric} is {value:.4g}, was {was}")
    return lines


def check_scene(name: str) -> list[str]:
    """What is wrong with one scene's errors; nothing when they have not risen."""
    stored = json.loads(STORED.read_text())
    device_scene = DeviceScene(load_scene(name), "cpu")
    if not same(stored["scenes"].get(name), signature(device_scene.scene)):
        return [f"{name}: the scene or its first view changed, so its references are of another"]
    with np.load(REFERENCES) as arrays:
        references = {kind: arrays[f"{name}-{kind}"].astype(np.float32) for kind in ("indirect", "full")}
    return complaints({name: measure_scene(device_scene, references)}, stored["errors"])


def update() -> None:
    """Store the errors of what is rendered now; references are kept while their scene is the same."""
    stored = json.loads(STORED.read_text()) if STORED.exists() else {"scenes": {}}
    kept = dict(np.load(REFERENCES)) if REFERENCES.exists() else {}
    scenes, errors, pictures = {}, {}, {}
    for name in SCENES:
        device_scene = DeviceScene(load_scene(name), "cpu")
        scenes[name] = signature(device_scene.scene)
        for component in (Component.INDIRECT, Component.FULL):
            key = f"{name}-{component.value}"
            if key not in kept or not same(stored["scenes"].get(name), scenes[name]):
                kept[key] = render(device_scene, component, method=Method.PATH, samples=REFERENCE_SAMPLES)
            pictures[key] = kept[key].astype(np.float16)
        references = {kind: pictures[f"{name}-{kind}"].astype(np.float32) for kind in ("indirect", "full")}
        errors[name] = measure_scene(device_scene, references)
    np.savez_compressed(REFERENCES, **pictures)
    STORED.write_text(json.dumps({"scenes": scenes, "errors": errors}, indent=1) + "\n")


def main(*, update_stored: bool) -> int:
    """The part of the command line; returns the exit status."""
    if update_stored:
        update()
        print(f"stored in {STORED.name} and {REFERENCES.name}")
        return 0
    lines = [line for name in SCENES for line in check_scene(name)]
    print("\n".join([*lines, ADVICE] if lines else ["no error rose"]))
    return 1 if lines else 0
