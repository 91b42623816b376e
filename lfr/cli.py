"""The command ``lfr``. What a subcommand needs is imported when it is called."""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Sequence
from importlib import import_module

from lfr import __version__
from lfr.program import run_program

# Name -> what it does, and the module with its ``add_arguments(parser)`` and ``run(options)``.
COMMANDS = {
    "import": ("make a LeRobot dataset of ROS 2 bags or a robomimic file", "lfr.importing.command"),
    "columns": (
        "print a dataset's columns, or a bag's topics, as a mapping",
        "lfr.importing.columns_command",
    ),
    "record": (
        "record demonstrations in a Gymnasium environment",
        "lfr.environments.record_command",
    ),
    "view": ("open an episode, a dataset or a training run in rerun", "lfr.view.command"),
    "verify": ("check a dataset for all that can be wrong", "lfr.curation.verify_command"),
    "replay": ("run recorded actions and compare the states", "lfr.curation.replay_command"),
    "recover": ("mend a cut-off MCAP log", "lfr.curation.recover_command"),
    "diff": ("what changed between two datasets, or leaks", "lfr.curation.diff_command"),
    "edit": ("delete, split or merge episodes of datasets", "lfr.curation.edit_command"),
    "card": ("write the cards of datasets and models", "lfr.hub.card_command"),
    "publish": ("publish a dataset or models, checked and whole", "lfr.hub.publish_command"),
    "export": ("write a trained policy for LeRobot's own scripts", "lfr.lerobot_plugin.export"),
}

JOURNEY = """\
from datasets to a policy:
  look      lfr view lerobot/pusht            any LeRobot dataset, log or run, in rerun
  trust     lfr verify DATASET                what is wrong with it, and where
  bring     lfr columns DATASET               what params.yaml is to say of your arm
  train     dvc repro open-loop@TRANSFER      skills, the mapping, and how far to trust it
  act       lfr export models/mapping/TRANSFER POLICY
  publish   lfr publish --help
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``lfr`` with the given arguments (default: the command line's); return the exit code."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(
        prog="lfr", description="Learn from Robot", epilog=JOURNEY,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--version", action="version", version=f"lfr {__version__}")
    commands = parser.add_subparsers(metavar="command", required=True)
    for name, (purpose, module) in COMMANDS.items():
        command = commands.add_parser(name, help=purpose)
        if arguments[:1] == [name]:  # `lfr --help` need not load them
            implementation = import_module(module)
            implementation.add_arguments(command)
            command.set_defaults(run=implementation.run)
    if not arguments:
        parser.print_help()
        return 0
    if arguments[0] not in COMMANDS and not arguments[0].startswith("-"):
        parser.error(_unknown(arguments[0]))
    options = parser.parse_args(arguments)
    return run_program(lambda: options.run(options))


def _unknown(command: str) -> str:
    near = difflib.get_close_matches(command, COMMANDS, n=1)
    if near:
        return f"unknown command '{command}'; did you mean '{near[0]}'?"
    return f"unknown command '{command}'; there are {', '.join(COMMANDS)}"
