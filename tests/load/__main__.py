"""`python -m tests.load`: see tests.load.options."""

import argparse
import asyncio
import sys
from collections.abc import Callable, Coroutine
from dataclasses import asdict

import httpx
from websockets.exceptions import InvalidHandshake

from gpu.errors import UserError
from tests.load.checks import Scale, quick
from tests.load.crowd import measure, plans
from tests.load.faults import check, chosen
from tests.load.figures import Row, level_row, table
from tests.load.options import level_of, open_target, parser, plan_of, serve_flags, server_log
from tests.load.paths import write_path
from tests.load.ramp import climb, search
from tests.load.recorder import Recorder
from tests.load.relay import relay
from tests.load.rest import Answers, Stills, drive, rest_row
from tests.load.results import environment, save


async def run(options: argparse.Namespace) -> int:
    """One crowd, and stills beside it."""
    level, answers = level_of(options), Answers()
    async with open_target(options, options.viewers) as target, asyncio.TaskGroup() as tasks:
        stills = None
        if options.rest_rate:
            beside = options.warm_up + options.seconds
            stills = tasks.create_task(drive(target, Stills(options.rest_rate), beside, answers))
        wanted = plans(plan_of(options), options.viewers, options.decode)
        row = await measure(target, wanted, options.seconds, options.warm_up)
        if stills:
            await stills
            row |= {"rest": rest_row(answers, options.warm_up + options.seconds)}
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
    results = {"environment": where, "options": said(options), "level": level_row(level), "largest": largest}
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
    scale = quick(ILLEGAL_SEED) if options.quick else Scale(ILLEGAL_SEED)
    log = server_log(options)
    for name in names:
        outcome = await check(name, scale, FAULT_WORKER[-1], serve_flags(options), log)
        rows[name] = asdict(outcome)
        missed += [f"{name}: {failure}" for failure in outcome.failures]
        print(f"{name}: {'failed' if outcome.failures else 'passed'} {outcome.measured}", flush=True)
    save(options.out, "faults", {"options": said(options), "checks": rows})
    return tell(missed)


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


COMMANDS: dict[str, Callable[[argparse.Namespace], Coroutine[None, None, int]]] = {
    "run": run,
    "ramp": ramp,
    "rest": rest,
    "faults": faults,
    "record": record,
}


def said(options: argparse.Namespace) -> Row:
    """The options as JSON has them."""
    return {
        name: value if isinstance(value, int | float | list | tuple) else str(value)
        for name, value in vars(options).items()
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
        return asyncio.run(COMMANDS[options.command](options))
    except (UserError, OSError, InvalidHandshake, httpx.HTTPError) as error:
        print(f"tests.load: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
