"""Owns the command line and the start of everything: the API, the studio on it, one port. Subcommands import lazily."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from studio.exit_codes import DONE, MEANING, STOPPED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="glider-studio",
        description="A design studio for underwater gliders with buoyancy cells.",
        epilog=MEANING,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    serve = commands.add_parser("serve", help="start the studio and the REST API on one port", epilog=MEANING)
    serve.add_argument("--host", help="address to listen on (GLIDER_STUDIO_HOST, 127.0.0.1)")
    serve.add_argument("--port", type=int, help="port to listen on (GLIDER_STUDIO_PORT, 8000); 0 takes a free one")
    serve.add_argument("--data", type=Path, help="folder for the studio's data (GLIDER_STUDIO_DATA)")
    simulate = commands.add_parser("simulate", help="simulate a design and write its run", epilog=MEANING)
    simulate.add_argument("design", type=Path, help="design file, or - for standard input")
    simulate.add_argument("-o", "--output", type=Path, help="result file: .nc (NetCDF) or .csv")
    validate = commands.add_parser("validate", help="check a design", epilog=MEANING)
    validate.add_argument("design", type=Path, help="design file, or - for standard input")
    presets = commands.add_parser("presets", help="list the presets, or print one as JSON", epilog=MEANING)
    presets.add_argument("preset", nargs="?", help="print this preset's design document")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    options = _parser().parse_args(arguments)
    try:
        if options.command == "serve":
            # matrices here are 6x6 at most: threads of the linear algebra library would only spin
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
            from studio.serve import serve

            return serve(host=options.host, port=options.port, data=options.data)
        from studio import commands

        if options.command == "simulate":
            return commands.simulate(options.design, options.output)
        if options.command == "validate":
            return commands.validate(options.design)
        return commands.presets(options.preset)
    except KeyboardInterrupt:
        return STOPPED
    except BrokenPipeError:  # the reader, say `head`, has seen enough
        sys.stderr.close()
        return DONE


if __name__ == "__main__":
    raise SystemExit(main())
