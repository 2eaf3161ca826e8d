"""The command line of the harness, and what its options mean."""

import argparse
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from server.cli.camera_argument import parse_size
from tests.load.figures import Level
from tests.load.paths import MADE, path_maker
from tests.load.target import Target, serving, target_at
from tests.load.viewer import Plan

ABOUT = """The load-test harness: viewers that walk, REST renders, faults and a soak, against a lumenwalk service.

    python -m tests.load run --url http://127.0.0.1:8000 --viewers 8
    python -m tests.load ramp --serve --device cuda:0 --size 1280x720 --viewers 1,4,16,32 --require 16 --out DIR

Only services on a loopback address are loaded, unless --remote says that the server is yours. --serve starts one for
the run; settings that have no option here come from LUMENWALK_… in the environment. The token of a running service is
$LUMENWALK_TOKEN. Results go to OUT/COMMAND.json. The exit status is 1 when a service level is missed, a fault is not
survived or memory grows, and 2 when the harness cannot do what was asked.
"""
SPARE_VIEWERS = 4


def parser() -> argparse.ArgumentParser:
    """All commands; `command` in the namespace is the name of the one given."""
    main = argparse.ArgumentParser(
        prog="python -m tests.load", description=ABOUT, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = main.add_subparsers(required=True, dest="command", metavar="COMMAND")
    target, walk, out = _target(), _walk(), _out()
    crowd = [target, walk, _measured(), out]

    run = commands.add_parser("run", parents=crowd, help="measure viewers; 1 if a level is missed")
    run.add_argument("--viewers", type=int, default=4, metavar="N", help="at the same time (%(default)s)")
    run.add_argument("--rest-rate", type=float, default=0.0, metavar="X", help="stills a second beside them (0)")

    ramp = commands.add_parser("ramp", parents=crowd, help="find how many viewers get the level")
    ramp.add_argument("--viewers", type=_numbers, metavar="N,N,…", help="measure these numbers, instead of searching")
    ramp.add_argument("--most", type=int, default=64, metavar="N", help="search up to so many (%(default)s)")
    ramp.add_argument("--require", type=int, default=1, metavar="N", help="fail if fewer get the level (%(default)s)")

    rest = commands.add_parser("rest", parents=[target, out], help="stills over REST at a steady rate")
    rest.add_argument("--rate", type=float, default=1.0, metavar="X", help="stills a second (%(default)s)")
    rest.add_argument("--seconds", type=float, default=20.0, metavar="X", help="for so long (%(default)s)")
    rest.add_argument("--size", type=parse_size, default="640x360", metavar="WxH", help="of a still (%(default)s)")

    soak = commands.add_parser("soak", parents=[target, walk, out], help="viewers come and go; memory must stay flat")
    soak.add_argument("--minutes", type=float, default=20.0, metavar="X", help="for so long (%(default)s)")
    soak.add_argument("--viewers", type=int, default=6, metavar="N", help="at most at the same time (%(default)s)")
    soak.add_argument("--rest-rate", type=float, default=0.2, metavar="X", help="stills a second (%(default)s)")
    soak.add_argument("--growth", type=float, default=1.0, metavar="X", help="allowed, in MB a minute (%(default)s)")

    faults = commands.add_parser("faults", parents=[_serve(), out], help="what a service of its own must survive")
    faults.add_argument("checks", nargs="*", metavar="CHECK", help="only these; all when none is named")
    faults.add_argument("--size", type=parse_size, default="640x360", metavar="WxH", help="of frames (%(default)s)")
    faults.add_argument("--viewers", type=int, metavar="N", help="let in so many, most of whom walk beside each check")
    faults.add_argument("--quick", action="store_true", help="with smaller numbers")

    record = commands.add_parser("record", parents=[target, out], help="record a walk in a browser as a camera path")
    record.add_argument("--seconds", type=float, default=600.0, metavar="X", help="at most (%(default)s)")

    commands.add_parser("plots", parents=[out], help="plots of the results in OUT; needs matplotlib")
    return main


@asynccontextmanager
async def open_target(
    options: argparse.Namespace, viewers: int = 0, flags: tuple[str, ...] = ()
) -> AsyncIterator[Target]:
    """The service that the options name; one started for them lets in as many viewers as are meant to come."""
    if not options.serve:
        yield target_at(options.url, os.environ.get("LUMENWALK_TOKEN"), remote=options.remote)
        return
    most = ("--max-viewers", str(viewers + SPARE_VIEWERS))
    async with serving([*serve_flags(options), *most, *flags], log=server_log(options)) as target:
        yield target


def server_log(options: argparse.Namespace) -> Path | None:
    """Where the words of a service started here go: into the folder of results, if there is one."""
    if options.out is None:
        return None
    options.out.mkdir(parents=True, exist_ok=True)
    return Path(options.out, "server.log")


def serve_flags(options: argparse.Namespace) -> list[str]:
    """Flags of a service started here."""
    given = {"--device": options.device, "--scene": options.scene}
    return [part for flag, value in given.items() if value for part in (flag, value)]


def plan_of(options: argparse.Namespace) -> Plan:
    """What each viewer does; UserError for a path that is not there."""
    counts = {"sp_clusters": options.sp_clusters, "vpl_clusters": options.vpl_clusters}
    settings: dict[str, Any] = {name: count for name, count in counts.items() if count is not None}
    stream = {"motion_scale": options.motion_scale} if options.motion_scale else {}
    return Plan(options.size, options.hz, None, settings, stream, path=path_maker(options.path), seed=options.seed)


def level_of(options: argparse.Namespace) -> Level:
    """The service level."""
    return Level(options.fps, options.age, options.decoded)


def _numbers(text: str) -> list[int]:
    return [int(part) for part in text.split(",")]


def _group() -> argparse.ArgumentParser:
    return argparse.ArgumentParser(add_help=False)


def _serve() -> argparse.ArgumentParser:
    group = _group()
    group.add_argument("--serve", action="store_true", help="start a service for this run")
    group.add_argument("--device", metavar="NAME", help="of that service: cpu, cuda:0, … (the best there is)")
    group.add_argument("--scene", metavar="SCENE", help="of that service: a file or a built-in name (cornell-box)")
    return group


def _target() -> argparse.ArgumentParser:
    group = _serve()
    group.add_argument("--url", default="http://127.0.0.1:8000", help="of a running service (%(default)s)")
    group.add_argument("--remote", action="store_true", help="the URL may be another machine: a server that is yours")
    return group


def _walk() -> argparse.ArgumentParser:
    group = _group()
    group.add_argument("--size", type=parse_size, default="1280x720", metavar="WxH", help="of frames (%(default)s)")
    group.add_argument("--hz", type=float, default=30.0, metavar="X", help="poses a second (%(default)s)")
    group.add_argument("--path", default="walk", metavar="PATH", help=f"{', '.join(MADE)} or a recorded file (walk)")
    group.add_argument("--seed", type=int, default=0, metavar="N", help="of paths and chances (%(default)s)")
    group.add_argument("--sp-clusters", type=int, metavar="N", help="render setting (by device)")
    group.add_argument("--vpl-clusters", type=int, metavar="N", help="render setting (by device)")
    group.add_argument("--motion-scale", type=float, metavar="X", help="side of moving frames, of 1 (by speed)")
    return group


def _measured() -> argparse.ArgumentParser:
    group = _group()
    group.add_argument("--seconds", type=float, default=20.0, metavar="X", help="measured (%(default)s)")
    group.add_argument("--warm-up", type=float, default=3.0, metavar="X", help="seconds before that (%(default)s)")
    group.add_argument("--decode", type=int, default=1, metavar="N", help="viewers that decode (%(default)s)")
    group.add_argument("--age", type=float, default=100.0, metavar="MS", help="95 %% of frames: pose to bytes (100)")
    group.add_argument("--decoded", type=float, metavar="MS", help="95 %% of frames: pose to decoded (not asked for)")
    group.add_argument("--fps", type=float, default=10.0, metavar="X", help="frames a second, at least (10)")
    return group


def _out() -> argparse.ArgumentParser:
    group = _group()
    group.add_argument("--out", type=Path, metavar="DIR", help="folder of results")
    return group
