"""`lumenwalk serve` for the harness: the same flags, and `--worker FILE`, a program that takes the renderer's place."""

import sys
from argparse import ArgumentParser
from pathlib import Path

from gpu.errors import UserError
from server.cli.options import add_options, given_options
from server.render.worker_process import WORKER
from server.serve import serve
from server.settings import ServerSettings, load_settings


def main() -> int:
    """Serve until SIGTERM."""
    parser = ArgumentParser(prog="python -m tests.load.host")
    parser.add_argument("--worker", type=Path, metavar="FILE")
    add_options(parser, ServerSettings, "as of `lumenwalk serve`")
    options = parser.parse_args()
    worker = (sys.executable, str(options.worker)) if options.worker else WORKER
    try:
        serve(load_settings(None, given_options(options, ServerSettings)), worker)
    except UserError as error:
        print(f"lumenwalk: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
