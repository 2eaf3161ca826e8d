"""The benchmark suite: times, errors, growth and flicker, as rows in JSON files, and plots of them.

    python -m tests.bench [PART …] --out DIR     all parts but those only run if named, if none is

Each part writes OUT/PART.json and goes on where an earlier run of the same commit stopped. Scenes are the built-in
ones, whose references are path-traced once, or `--scenes DIR` of NAME.glb with `--references DIR` of NAME.npz: arrays
`full` and `direct` (and `full_aa`, rays spread over the pixel, for Mitsuba) of linear radiance, Lambertian surfaces.
"""

import argparse
import sys
from importlib import import_module
from pathlib import Path

from gpu.errors import UserError
from tests.bench.store import Budget
from tests.bench.subjects import Size
from tests.bench.suite import Suite

PARTS = {
    "sweep": "times and errors of indirect light over clusters, VPLs, fuzziness and weighting",
    "decompose": "bias and noise of VPLs and of clustering",
    "temporal": "flicker along a walk",
    "targets": "how well a wanted time or error is held along a walk",
    "skips": "gain and error of each switch",
    "shadow_maps": "rsm-disks beside its paper, path tracing of one bounce and other methods; only if named",
    "photons": "photon-gather beside its paper and other methods, and its growth; only if named",
    "edges": "edges in a walk, and its times, with frames averaged over the pixels and without; only if named",
    "still": "error over time of a view that rests",
    "noise": "noise and bias of such a view, of direct and indirect light apart; only if named",
    "peers": "error over time of path tracing, here and by Mitsuba 3",
    "materials": "errors with the files' own materials, beside `--references` of these; only if named",
    "growth": "time over shading points, VPLs and triangles",
    "pictures": "pictures and error maps",
    "walk": "frames a second",
    "floors": "times of stages beside what bytes, operations and rays would take",
    "survey": "all of those in about twenty minutes of an H100, the dear ones in fewer scenes; only if named",
    "plots": "plots of the JSON files",
    "page": "the page of results, of the JSON files and plots",
    "gate": "check the small renders that must not get worse; --update stores them anew; only if named",
}


def size_of(text: str) -> Size:
    """WIDTHxHEIGHT."""
    width, height = (int(side) for side in text.split("x"))
    return width, height


def parser() -> argparse.ArgumentParser:
    """The command line."""
    lines = "\n".join(f"  {name:10} {what}" for name, what in PARTS.items())
    command = argparse.ArgumentParser(
        prog="python -m tests.bench",
        description=f"{__doc__}\nparts:\n{lines}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("parts", nargs="*", metavar="PART", help="one of those above")
    command.add_argument("--out", type=Path, default=Path("build/bench"), help="folder of results (%(default)s)")
    command.add_argument("--cache", type=Path, help="folder of references that were rendered (OUT/cache)")
    command.add_argument("--page", type=Path, help="the page of results; its plots lie beside it (OUT/results.md)")
    command.add_argument("--scenes", type=Path, help="folder of NAME.glb, instead of the built-in scenes")
    command.add_argument("--references", type=Path, help="folder of NAME.npz with path-traced pictures")
    command.add_argument("--scenes-named", nargs="+", default=[], metavar="NAME", help="only these scenes")
    command.add_argument("--groups", nargs="+", default=[], metavar="GROUP", help="only these groups of the sweep")
    command.add_argument("--size", type=size_of, default=(1024, 720), help="where no reference says it (1024x720)")
    command.add_argument("--device", help="cpu, cuda:0, …")
    command.add_argument("--seconds", type=float, help="start no new row after this time; parts share it")
    command.add_argument("--reference-samples", type=int, help="paths a pixel of references (4096; on a CPU 256)")
    command.add_argument("--quick", action="store_true", help="a trial with much less of everything")
    command.add_argument("--update", action="store_true", help="of the gate: what is rendered now becomes the measure")
    return command


def main() -> int:
    """Run the parts that were asked for; returns the exit status."""
    command = parser()
    options = command.parse_args()
    parts = options.parts or [name for name, what in PARTS.items() if not what.endswith("only if named")]
    if unknown := set(parts) - set(PARTS):
        command.error(f"no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    try:
        if "gate" in parts:
            from tests.bench import gate

            return gate.main(update_stored=options.update)
        suite = Suite(
            out=options.out,
            cache=options.cache or options.out / "cache",
            device=options.device,
            scenes=options.scenes,
            references=options.references,
            names=tuple(options.scenes_named),
            groups=tuple(options.groups),
            size=options.size,
            quick=options.quick,
            page_file=options.page,
            reference_samples=options.reference_samples,
        )
        budget = Budget(options.seconds)
        for number, part in enumerate(parts):
            suite.budget = budget.share(len(parts) - number)
            import_module(f"tests.bench.{part}").run(suite)
    except UserError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
