"""`lfr verify PATH --fix`: what is certain mended, as a copy or in place."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.errors import LfrError

if TYPE_CHECKING:
    from lfr.curation.repair.plan import Plan
    from lfr.curation.verify import Report


OTHERS = ("accept", "good", "scores", "html", "markdown", "revision")  # options of verify


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr verify` that are about mending."""
    parser.add_argument(
        "--fix",
        action="store_true",
        help="say what of it can be mended with certainty; with --out or --in-place, mend it",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--out", type=Path, metavar="NEW", help="with --fix: a mended copy")
    where.add_argument(
        "--in-place",
        action="store_true",
        help="with --fix: replace what changes, the old files kept in PATH.before-fix",
    )


def asked(arguments: argparse.Namespace) -> bool:
    """Whether mending is asked for.

    Raises:
        LfrError: where to write is given, and not that something is to be mended; or what does not
            go with mending is asked for, too.
    """
    if not arguments.fix and (arguments.out or arguments.in_place):
        raise LfrError("found --out or --in-place without --fix; expected --fix too")
    besides = [name for name in OTHERS if getattr(arguments, name)]
    if arguments.fix and besides:
        raise LfrError(f"found --{besides[0]} with --fix; expected one after the other")
    return arguments.fix


def about_lost_info(path: Path) -> str:
    """What to do where the info.json of the dataset at `path` is lost or cut off; "" where there is
    nothing that this could do.
    """
    from lfr.curation.repair.info import can_rebuild

    return f"`lfr verify {path} --fix` rebuilds it from the other files" * can_rebuild(path)


def run(arguments: argparse.Namespace) -> Report:
    """Mend, or say what would be mended.

    Returns:
        What the exit code is of: the dataset that was written, or else the one that there is.

    Raises:
        LfrError: the folder to write is there already.
        DataError: there is no LeRobot v3.0 dataset at the path, nor what is left of one.
    """
    from lfr.curation.checks.logs import default_folder
    from lfr.curation.repair import apply
    from lfr.curation.repair.plan import inspect, planned

    path, out, pictures = arguments.path, arguments.out, arguments.pictures
    logs = arguments.logs or default_folder(path)
    if out:
        apply.check_new(path, out)
    backup = written = None
    with planned(path, logs, pictures) as plan:
        if out and plan.draft.changed:
            apply.write_new(plan.draft, out)
            written = out
        elif arguments.in_place and plan.draft.changed:
            backup = apply.replace_in_place(plan.draft, path)
            written = path
    if arguments.in_place:
        backup = backup or apply.end_unfinished(path)
    if written:
        plan = replace(plan, after=inspect(written, logs, pictures))
    if arguments.json:
        print(json.dumps(_as_json(plan, written, backup), indent=2, ensure_ascii=False))
    else:
        print("\n".join(_lines(plan, written, backup)))
    return _there_is(plan, written)


def _lines(plan: Plan, written: Path | None, backup: Path | None) -> Iterator[str]:
    from lfr.curation.repair.apply import backup_of

    yield from map(str, plan.before.findings)
    yield str(plan.before)
    done, left = ("mended", "left") if written else ("would mend", "would be left")
    for repair in plan.repairs:
        yield f"{done}: {repair}"
    for reason in plan.reasons:
        yield f"not mended: {reason}"
    path = plan.before.path
    if not plan.draft.changed:
        yield "nothing to mend" if not plan.before.findings else "nothing of it can be mended"
    else:
        for finding in plan.after.findings:
            yield f"{left}: {finding}"
        yield str(plan.after)
        if not written:
            yield (f"nothing is written; go on with: lfr verify {path} --fix --out NEW, a mended "
                   f"copy; or --in-place, the old files kept in {backup_of(path)}")  # fmt: skip
    if backup:
        yield f"the old files are in {backup}"


def _as_json(plan: Plan, written: Path | None, backup: Path | None) -> dict[str, Any]:
    fix = {
        "before": [finding.as_json() for finding in plan.before.findings],
        "repairs": [asdict(repair) for repair in plan.repairs],
        "not_mended": plan.reasons,
        "after": [finding.as_json() for finding in plan.after.findings],
        "written": written and str(written),
        "backup": backup and str(backup),
    }
    return {**_there_is(plan, written).as_json(), "fix": fix}


def _there_is(plan: Plan, written: Path | None) -> Report:
    return plan.after if written else plan.before
