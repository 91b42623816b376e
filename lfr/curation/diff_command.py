"""`lfr diff A B`: what changed between two datasets; `--leakage`: what they share."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

VALID = (
    "the folder of a LeRobot dataset (v3.0, v2.1 or v2.0), its name on the Hub (owner/name or "
    "owner/name@revision), or logs that are packed for the comparison"
)
FOUND = 1  # exit code; 2 is what is not a dataset at all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr diff`."""
    parser.add_argument("a", type=Path, help=f"{VALID}; or TRAIN")
    parser.add_argument("b", type=Path, help="another one; or TEST")
    parser.add_argument("--leakage", action="store_true", help="say what TRAIN and TEST share")
    parser.add_argument("--json", action="store_true", help="print one JSON object, for machines")
    parser.add_argument(
        "--pictures",
        type=int,
        default=10,
        metavar="N",
        help="compare every N-th frame where videos are encoded differently (default 10); 0 leaves "
        "the videos",
    )
    parser.add_argument(
        "--lines",
        type=int,
        default=10,
        metavar="N",
        help="name the N dimensions whose statistics moved furthest (default 10)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print what differs, or what is shared; 1 where there is something, 0 where there is nothing.

    Raises:
        LfrError: one is no LeRobot dataset and no logs, or cannot be read.
    """
    from lfr.curation.diff.comparison import compare_datasets, compare_leakage
    from lfr.curation.diff.forms import as_dataset

    pictures, lines = max(arguments.pictures, 0), max(arguments.lines, 0)
    with as_dataset(arguments.a) as a, as_dataset(arguments.b) as b:
        if arguments.leakage:
            found = compare_leakage(a, b, pictures=pictures > 0)
        else:
            found = compare_datasets(a, b, pictures=pictures, lines=lines)
    if arguments.json:
        print(json.dumps(found.as_json(), indent=2))  # in ASCII: nothing commands a terminal
    else:
        for line in found.lines:
            print(line)
        print(found)
    return FOUND if found.differences else 0
