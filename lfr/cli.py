"""The command ``lfr``. What a subcommand needs is imported when it is called."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from lfr import __version__
from lfr.program import run_program


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``lfr`` with the given arguments (default: the command line's); return the exit code."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(prog="lfr", description="Learn from Robot")
    parser.add_argument("--version", action="version", version=f"lfr {__version__}")
    commands = parser.add_subparsers(metavar="command", required=True)
    view = commands.add_parser("view", help="open an episode, a dataset or a training run in rerun")
    if arguments[:1] == ["view"]:  # `lfr --help` need not load it
        from lfr.view import command

        command.add_arguments(view)
        view.set_defaults(run=command.run)
    options = parser.parse_args(arguments)
    return run_program(lambda: options.run(options))
