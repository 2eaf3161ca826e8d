"""Indirect light of `fuzzy-vpl` on real scenes: stage times, and errors against path tracing and `exact-vpl`.

    python -m tests.bench.indirect --scenes DIR --references DIR --out results.json [--exact] [SCENE …]

DIR/NAME.glb are the scenes, DIR/NAME.npz their path-traced images with arrays `full` and `direct` (linear, through
pixel centres, Lambertian surfaces). Total error: against full − direct. Clustering error: against `exact-vpl` with the
same VPLs. Times: medians over frames after warm-up, by device events on CUDA.
"""

import argparse
import json
import os
import platform
import subprocess
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import warp as wp

from gpu.metrics import measure
from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.scene import load_scene
from gpu.scene.types import Floats
from gpu.settings import Component, Method, RenderSettings

SCENES = ("conference", "cornell-box", "living-room", "sponza", "staircase", "veach-bidir")
INDIRECT_STAGES = ("cluster", "visibility", "shade", "check", "refine")
WARM_UP, FRAMES = 5, 25


def environment(device: wp.Device) -> dict[str, str]:
    """What the figures were measured on and with; $COMMIT names the commit of a tree that came without git."""
    git = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    commit = os.environ.get("COMMIT", git)
    return {
        "device": device.name,
        "warp": wp.config.version,
        "python": platform.python_version(),
        "commit": commit or "unknown",
    }


def stage_times(renderer: Renderer, resident: ResidentScene) -> dict[str, dict[str, float]]:
    """Median, 5th and 95th percentile of each stage over FRAMES frames from the scene's first camera [ms]."""
    camera = resident.scene.cameras[0]
    runs = [renderer.render(camera).stats.stage_ms for _ in range(WARM_UP + FRAMES)][WARM_UP:]
    table = {}
    for stage in runs[0]:
        low, median, high = np.percentile([run[stage] for run in runs], (5, 50, 95))
        table[stage] = {"median": float(median), "p5": float(low), "p95": float(high)}
    return table


def exact_image(resident: ResidentScene, size: tuple[int, int], settings: RenderSettings) -> Floats:
    """The same VPLs, each with a shadow ray from every pixel."""
    settings = settings.model_copy(update={"method": Method.EXACT_VPL})
    return Renderer(resident, size, settings).render(resident.scene.cameras[0]).radiance()


def measure_scene(
    scenes: Path, references: Path, name: str, settings: RenderSettings, *, exact: bool
) -> dict[str, Any]:
    """One scene's row of the table."""
    resident = ResidentScene(load_scene(str(scenes / f"{name}.glb")))
    images = np.load(references / f"{name}.npz")
    reference = images["full"].astype(np.float32) - images["direct"].astype(np.float32)
    height, width = reference.shape[:2]
    renderer = Renderer(resident, (width, height), settings)
    frame = renderer.render(resident.scene.cameras[0])
    render = frame.radiance()
    times = stage_times(renderer, resident)
    row: dict[str, Any] = {
        "scene": name,
        "size": [width, height],
        "triangles": len(resident.scene.triangles),
        "indirect_ms": sum(times[stage]["median"] for stage in INDIRECT_STAGES if stage in times),
        "stages": times,
        "counts": frame.stats.counts,
        "skips": frame.stats.skips,
        "total": asdict(measure(render, reference)),
    }
    if exact:
        exact_render = exact_image(resident, (width, height), settings)
        row["clustering"] = asdict(measure(render, exact_render))
        row["vpl_bias"] = asdict(measure(exact_render, reference))
    return row


def markdown(rows: list[dict[str, Any]]) -> str:
    """The rows as the README shows them."""
    lines = ["| scene | stages | relMSE | MSE | energy | clustering MSE |", "|---|---|---|---|---|---|"]
    for row in rows:
        total, clustering = row["total"], row.get("clustering", {"mse": float("nan")})
        width, height = row["size"]
        lines.append(
            f"| {row['scene']} {width}×{height} | {row['indirect_ms']:.1f} ms | {total['rel_mse']:.3f} | "
            f"{total['mse']:.1e} | {total['energy']:.3f} | {clustering['mse']:.1e} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Measure the scenes named on the command line, or all, and write the results as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="SCENE", help=f"default: {' '.join(SCENES)}")
    parser.add_argument("--scenes", type=Path, required=True)
    parser.add_argument("--references", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--exact", action="store_true", help="also render exact-vpl (seconds to minutes a scene)")
    parser.add_argument("--sp-clusters", type=int, default=8192)
    parser.add_argument("--vpl-clusters", type=int, default=2048)
    parser.add_argument("--vpls", type=int, default=98_304)
    options = parser.parse_args()
    settings = RenderSettings(
        component=Component.INDIRECT,
        lambertian=True,
        sp_clusters=options.sp_clusters,
        vpl_clusters=options.vpl_clusters,
        vpls=options.vpls,
    )
    rows = []
    for name in options.names or SCENES:
        row = measure_scene(options.scenes, options.references, name, settings, exact=options.exact)
        total, clustering = row["total"], row.get("clustering", {"mse": float("nan")})
        print(
            f"{name:12} {row['indirect_ms']:6.2f} ms  relMSE {total['rel_mse']:.4f}  MSE {total['mse']:.2e}  "
            f"energy {total['energy']:.3f}  clustering MSE {clustering['mse']:.2e}  "
            f"non-finite {total['nonfinite']}  unassigned {row['counts']['unassigned']}",
            {stage: round(time["median"], 2) for stage, time in row["stages"].items()},
            flush=True,
        )
        rows.append(row)
    result = {"environment": environment(wp.get_preferred_device()), "settings": settings.model_dump(), "rows": rows}
    options.out.write_text(json.dumps(result, indent=1) + "\n")
    print(markdown(rows))


if __name__ == "__main__":
    main()
