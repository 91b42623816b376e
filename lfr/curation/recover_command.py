"""`lfr recover LOG`: a cut-off MCAP file made readable, beside it."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr recover`."""
    parser.add_argument(
        "log", type=Path, help="a cut-off MCAP file: a .mcap.partial, or a .mcap that does not open"
    )


def run(arguments: argparse.Namespace) -> None:
    """Mend a log into `<name>.recovered.mcap` and say what was lost.

    Raises:
        DataError: there is nothing to recover, or it was recovered before.
    """
    from lfr.curation.recover import recover

    print(recover(arguments.log))
