"""`python -m tests.load`: see tests.load.options."""

import argparse
import asyncio
import gc
import sys
from collections.abc import Callable, Coroutine
from dataclasses import asdict, replace

import httpx
from websockets.exceptions import InvalidHandshake

from gpu.errors import UserError
from tests.load.checks import Scale, quick
from tests.load.crowd import measure, plans
from tests.load.faults import check, chosen
from tests.load.figures import Row, table
from tests.load.options import SPARE_VIEWERS, level_of, open_target, parser, plan_of, serve_flags, server_log
from tests.load.paths import write_path
from tests.load.ramp import climb, search
from tests.load.recorder import Recorder
from tests.load.relay import relay
from tests.load.rest import Answers, Stills, drive, rest_row
from tests.load.results import environment, save
from tests.load.soak import Soak
from tests.load.soak import soak as soak_service


async def run(options: argparse.Namespace) -> int:
    """One crowd, and stills beside it."""
    level, plan, answers = level_of(options), plan_of(options), Answers()
    whole = options.warm_up + options.seconds
    async with open_target(options, options.viewers) as target:
        row, _ = await asyncio.gather(
            measure(target, plans(plan, options.viewers, options.decode), options.seconds, options.warm_up),
            drive(target, Stills(options.rest_rate), whole, answers),
        )
        if options.rest_rate:
            row["rest"] = rest_row(answers, whole)
            row["errors"] |= row["rest"]["errors"]
        results = {"environment": await environment(target), "options": said(options), "rows": [row]}
    save(options.out, "run", results)
    print(table([row]))
    return tell(level.missed(row))


async def ramp(options: argparse.Namespace) -> int:
    """Crowds of several sizes."""
    level, plan, rows = level_of(options), plan_of(options), []
    most = max(options.viewers or [options.most])
    async with open_target(options, most) as target:

        async def fits(viewers: int) -> bool:
            row = await measure(target, plans(plan, viewers, options.decode), options.seconds, options.warm_up)
            missed = level.missed(row)
            rows.append(row | {"missed": missed})
            print(table(rows).splitlines()[-1] if len(rows) > 1 else table(rows), flush=True)
            return not missed

        largest = await (climb(fits, options.viewers) if options.viewers else search(fits, options.most))
        where = await environment(target)
    rows.sort(key=lambda row: row["viewers"])
    results = {"environment": where, "options": said(options), "level": asdict(level), "largest": largest}
    save(options.out, "ramp", results | {"rows": rows})
    print(f"{largest} viewers get the service level")
    first: list[str] = next((row["missed"] for row in rows if row["missed"]), [])
    return tell(first if largest < options.require else [])


async def rest(options: argparse.Namespace) -> int:
    """Stills."""
    answers = Answers()
    async with open_target(options) as target:
        await drive(target, Stills(options.rate, options.size), options.seconds, answers)
        row = rest_row(answers, options.seconds)
        save(options.out, "rest", {"environment": await environment(target), "options": said(options), "rows": [row]})
    wait = row["wait"] or {}
    print(f"{row['rendered_a_second']:.2f} stills a second of {options.rate:g}, p95 {wait.get('p95', 0):.0f} ms")
    print(", ".join(f"{count} × {status}" for status, count in row["statuses"].items()))
    return tell([f"{count} × {error}" for error, count in row["errors"].items()])


async def faults(options: argparse.Namespace) -> int:
    """Each check in turn."""
    if not options.serve:
        raise UserError("faults kill the renderer and end the service: --serve starts one for that")
    from tests.load.fault_worker import FAULT_WORKER, ILLEGAL_SEED  # the renderer itself

    names, rows, missed = chosen(options.checks), {}, []
    scale = replace(quick(ILLEGAL_SEED) if options.quick else Scale(ILLEGAL_SEED), size=options.size)
    if options.viewers:
        scale = replace(scale, viewers=options.viewers, walkers=max(options.viewers - SPARE_VIEWERS, 0))
    log = server_log(options)
    for name in names:
        outcome = await check(name, scale, FAULT_WORKER[-1], serve_flags(options), log)
        rows[name] = asdict(outcome)
        missed += [f"{name}: {failure}" for failure in outcome.failures]
        print(f"{name}: {'failed' if outcome.failures else 'passed'} {outcome.measured}", flush=True)
    save(options.out, "faults", {"options": said(options), "checks": rows})
    return tell(missed)


async def soak(options: argparse.Namespace) -> int:
    """Many visits. With the uploads there are more scenes than are kept, so that they are loaded again and again."""
    what = Soak(plan_of(options), 60.0 * options.minutes, options.viewers, options.rest_rate, options.growth)
    async with open_target(options, options.viewers, ("--max-scenes", "4")) as target:
        row = await soak_service(target, what)
        where = await environment(target)
    save(options.out, "soak", {"environment": where, "options": said(options), "row": row})
    print(f"{row['visits']} visits, {row['changes']} changes, {row['frames']} frames, {row['uploads']} uploads")
    for name, line in row["growth"].items():
        print(f"{name[:-3]:7} {line['last']:8.1f} MB, {line['mb_a_minute']:+.3f} ± {line['error']:.3f} MB a minute")
    return tell(row["missed"])


async def record(options: argparse.Namespace) -> int:
    """A walk in a browser."""
    if options.out is None:
        raise UserError("--out: a folder is needed to record into")
    recorder = Recorder()
    async with open_target(options, 1) as target, relay(target.address, tap=recorder.tap) as url:
        print(f"walk at {url}/{f'?token={target.token}' if target.token else ''}, then press Ctrl-C", flush=True)
        try:
            await asyncio.sleep(options.seconds)
        finally:  # Ctrl-C cancels
            if recorder.views:
                options.out.mkdir(parents=True, exist_ok=True)
                write_path(options.out / "path.jsonl", recorder.times, recorder.views)
            print(f"{len(recorder.views)} poses in {options.out / 'path.jsonl'}")
    return 0


async def plots(options: argparse.Namespace) -> int:
    """Pictures of results."""
    if options.out is None:
        raise UserError("--out: the folder of results to plot is needed")
    try:
        from tests.load.plots import draw
    except ImportError:
        raise UserError("plots need matplotlib: pip install --editable .[bench]") from None
    for file in draw(options.out):
        print(file)
    return 0


COMMANDS: dict[str, Callable[[argparse.Namespace], Coroutine[None, None, int]]] = {
    "run": run,
    "ramp": ramp,
    "rest": rest,
    "faults": faults,
    "soak": soak,
    "record": record,
    "plots": plots,
}


def said(options: argparse.Namespace) -> Row:
    """The options that were given or have a default, as JSON has them."""
    return {
        name: value if isinstance(value, int | float | list | tuple) else str(value)
        for name, value in vars(options).items()
        if value is not None
    }


def tell(missed: list[str]) -> int:
    """Say what is wrong; the exit status."""
    for line in missed:
        print(f"missed: {line}", file=sys.stderr)
    return 1 if missed else 0


def main() -> int:
    """Run one command; returns the exit status."""
    try:
        options = parser().parse_args()
        gc.collect()
        gc.freeze()  # a full collection takes a tenth of a second of the viewers' time, as if the service had been slow
        return asyncio.run(COMMANDS[options.command](options))
    except (UserError, OSError, InvalidHandshake, httpx.HTTPError) as error:
        print(f"tests.load: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
