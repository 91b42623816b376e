"""`lfr verify PATH`: whether a dataset or logs can be trusted, and where they cannot."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lfr.curation.repair import command as repair
from lfr.errors import DataError, LfrError

if TYPE_CHECKING:
    from lfr.curation.verify import Report

VALID = (
    "the folder of a LeRobot dataset (v3.0, v2.1 or v2.0), its name on the Hub (owner/name or "
    "owner/name@revision), an MCAP log, or a folder of logs"
)
WRONG = 1  # exit code; 2 is what is not a dataset at all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr verify`."""
    parser.add_argument("path", type=Path, help=VALID)
    parser.add_argument("--revision", help="of a dataset on the Hub: a branch, tag or commit")
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
    judged = parser.add_argument_group("what counts")
    judged.add_argument(
        "--fail-on", metavar="WHAT", dest="fail_on",
        help="error (default), warning, none, or kinds as in stuck,jump: exit with 1 on these",
    )  # fmt: skip
    judged.add_argument(
        "--accept", type=Path, metavar="FILE",
        help="known findings to set aside: what --json printed, or a list of check, episode, "
        "column, file",
    )  # fmt: skip
    judged.add_argument(
        "--min-score", type=float, metavar="S", dest="min_score",
        help="what an episode must score for --good (default 1: nothing is found)",
    )  # fmt: skip
    shown = parser.add_argument_group("what is printed and written")
    printed = shown.add_mutually_exclusive_group()
    printed.add_argument("--json", action="store_true", help="one JSON object, for machines")
    printed.add_argument("--scores", action="store_true", help="a score for each episode, and why")
    printed.add_argument(
        "--good", action="store_true",
        help="nothing but the good episodes, for lerobot-train --dataset.episodes",
    )  # fmt: skip
    shown.add_argument("--html", type=Path, metavar="FILE", help="write a page with pictures")
    shown.add_argument("--markdown", type=Path, metavar="FILE", help="write a short summary")
    repair.add_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print what is wrong, mend it where asked; 1 when there is what `--fail-on` names.

    Raises:
        LfrError: there is neither a LeRobot dataset nor a log at the path, or an argument does not
            fit.
    """
    from lfr.curation.accepted import accept, read_accepted
    from lfr.curation.fail_on import FailOn
    from lfr.curation.verify_logs import has_logs, verify_logs
    from lfr.data.opening import opened

    # A list of good episodes is there because others are not, so it alone is no failure.
    fail_on = FailOn.parse(arguments.fail_on or ("none" if arguments.good else "error"))
    if repair.asked(arguments):
        return WRONG if fail_on.fails(repair.run(arguments).findings) else 0
    least = _least(arguments)
    for option in ("html", "markdown"):
        path = getattr(arguments, option)
        if path is not None and path.is_dir():  # which writing would put the file in place of
            raise LfrError(f"--{option} writes a file: found the folder {path}")
    entries = [] if arguments.accept is None else read_accepted(arguments.accept)
    with opened(arguments.path, arguments.revision, verify=True) as path:
        if has_logs(path):
            report = verify_logs(path, arguments.pictures)
        else:
            report = _verified(path, arguments)
        if arguments.accept is not None:
            report = accept(report, entries, arguments.accept)
        _write(arguments, report)
    if arguments.good:
        _print_good(report, least)
    elif arguments.json:
        print(json.dumps(report.as_json(), indent=2, ensure_ascii=False))
    else:
        _print(report, arguments.scores)
    return WRONG if fail_on.fails(report.findings) else 0


def _verified(path: Path, arguments: argparse.Namespace) -> Report:
    """The report of a dataset; with what to do where its info.json is in the way of all checks."""
    from lfr.curation.verify import verify_dataset

    is_here = path == arguments.path
    try:
        report = verify_dataset(path, arguments.logs, arguments.pictures)
    except DataError as error:
        if is_here and (advice := repair.about_lost_info(path)):
            raise LfrError(f"{error}; {advice}") from error
        raise
    if is_here and report.contents is None and (advice := repair.about_lost_info(path)):
        print(f"note: of meta/info.json: {advice}", file=sys.stderr)
    return report


def _write(arguments: argparse.Namespace, report: Report) -> None:
    from lfr.curation.report.html import write_html
    from lfr.curation.report.markdown import write_markdown

    for path, write in ((arguments.html, write_html), (arguments.markdown, write_markdown)):
        if path is None:
            continue
        try:
            write(report, path)
        except OSError as error:
            raise LfrError(f"{path} cannot be written: {error.strerror}") from error


def _print(report: Report, scores: bool) -> None:
    from lfr.curation.scores import table

    for line in [table(report.scores)] if scores else report.findings:
        print(line)
    if report.unmatched:
        print(report.unmatched)
    print(report)


def _print_good(report: Report, least: float) -> None:
    from lfr.curation.scores import about_all, good

    for finding in about_all(report.errors, report.lengths):
        print(f"note: of the whole dataset: {finding}", file=sys.stderr)
    if report.unmatched:
        print(f"note: {report.unmatched}", file=sys.stderr)
    episodes = good(report.scores, least)
    if not episodes:
        raise LfrError(f"no episode of {report.path} scores {least:g} or more; see --scores, and "
                       "--accept or --min-score for what may stay")  # fmt: skip
    print(json.dumps(episodes, separators=(",", ":")))


def _least(arguments: argparse.Namespace) -> float:
    if arguments.min_score is not None and not arguments.good:
        raise LfrError("--min-score says which episodes --good lists; add --good")
    least = 1.0 if arguments.min_score is None else arguments.min_score
    if not 0 <= least <= 1:
        raise LfrError(f"--min-score: found {least:g}, expected 0 to 1")
    return least
