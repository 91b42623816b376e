"""`lfr verify PATH`: whether a dataset or logs can be trusted, and where they cannot."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

VALID = (
    "the folder of a LeRobot dataset (v3.0, v2.1 or v2.0), its name on the Hub (owner/name), "
    "an MCAP log, or a folder of logs"
)
WRONG = 1  # exit code; 2 is what is not a dataset at all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr verify`."""
    parser.add_argument("path", type=Path, help=VALID)
    parser.add_argument("--revision", help="of a dataset on the Hub: a branch, tag or commit")
    parser.add_argument("--json", action="store_true", help="print one JSON object, for machines")
    parser.add_argument(
        "--logs",
        type=Path,
        metavar="DIR",
        help="the MCAP logs it was packed from (default: data/logs/<name> beside its folder)",
    )
    parser.add_argument(
        "--pictures",
        type=int,
        nargs="?",
        const=2,
        metavar="N",
        help="decode every N-th frame of the videos (default 2) and look at what they show",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print what is wrong; 1 when there is an error, 0 when there are warnings at most.

    Raises:
        LfrError: there is neither a LeRobot dataset nor a log at the path.
    """
    from lfr.curation.verify import verify_dataset
    from lfr.curation.verify_logs import has_logs, verify_logs
    from lfr.data.opening import opened

    with opened(arguments.path, arguments.revision, verify=True) as path:
        if has_logs(path):
            report = verify_logs(path, arguments.pictures)
        else:
            report = verify_dataset(path, arguments.logs, arguments.pictures)
    if arguments.json:
        print(json.dumps(report.as_json(), indent=2, ensure_ascii=False))
    else:
        for finding in report.findings:
            print(finding)
        print(report)
    return WRONG if report.errors else 0
