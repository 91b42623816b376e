"""Faults planted into clean datasets, and which of them dataset checkers find.

    python -m benchmarks.checkers [--only lfr] [--faults values,nan_action] [--again]
    python -m benchmarks.checkers.page        # the table in docs/trust.md

Each fault is put alone into a copy of a clean dataset (`benchmarks.checkers.bases`), which each
checker is then given, one after the other, in its newest version from PyPI, in an environment of
its own. A fault is found where a checker says something of the copy that it does not say of the
clean dataset (`benchmarks.checkers.findings`); of this project's it must also fit. Videos are
decoded, where a checker does so if asked, for faults of videos. Rows of checkers.csv stay, unless
the checker has another version since.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection
from pathlib import Path

from benchmarks._figures import FOLDER, Figure, show, write
from benchmarks.checkers.bases import NAMES
from benchmarks.checkers.faults import FAULTS, GROUPS
from benchmarks.checkers.peers import CHECKERS, OWN
from benchmarks.checkers.results import CLEAN, Row, alarms, by_group, only, total
from benchmarks.checkers.run import Run
from lfr.artifacts import read_json
from lfr.errors import UnknownNameError
from lfr.program import run_program

GOALS = {"all": 0.85, "pictures": 1.0, "behaviour": 30 / 35}  # of the faults
SECONDS_GOAL = 5.0  # of processor time, for 1,000 state-only episodes


def figures(rows: list[Row], seconds: float | None) -> list[Figure]:
    """What this project's is to reach, of what there are rows."""
    groups = by_group(rows).get(OWN, {})
    found = []
    for name, goal in GOALS.items() if groups else ():
        if name not in ("all", *groups):
            continue
        here, of = total(groups) if name == "all" else groups[name]
        part = here / of
        found.append(Figure(f"found/{name}", "faults", part, goal, (part, part), here, of))
    said, of = alarms(row for row in rows if row.fault != "lerobot").get(OWN, (0, 0))
    found.append(Figure("alarms", "datasets", said, 0, (said, said), said, of, at_most=True))
    if seconds is not None:
        part = seconds / SECONDS_GOAL
        found.append(Figure("seconds/1000_episodes", "s", part, 1.0, (part, part), seconds,
                            SECONDS_GOAL, at_most=True))  # fmt: skip
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", type=_names, help="checkers, comma-separated", metavar="NAMES")
    parser.add_argument("--faults", type=_names, help="faults or groups", metavar="NAMES")
    parser.add_argument("--again", action="store_true", help="also where there is a row already")
    parser.add_argument("--dataset", type=Path, help="taken in place of recording one")
    parser.add_argument("--logs", type=Path, help="its logs")
    parser.add_argument("--clean", type=Path, nargs="*", default=[], metavar="DATASET",
                        help="datasets in which nothing is wrong")  # fmt: skip
    parser.add_argument("--work", type=Path, default=Path("work/benchmarks/checkers"))
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args()
    return run_program(lambda: _run(options))


def _run(options: argparse.Namespace) -> None:
    _check("checker", options.only, CHECKERS)
    _check("fault", options.faults, [*FAULTS, *GROUPS, CLEAN])
    options.work = options.work.resolve()
    run = Run(options)
    wanted = options.faults or [*FAULTS, CLEAN]
    for name, fault in FAULTS.items():
        if name in wanted or fault.group in wanted or not options.faults:
            checkers = list(run.missing(name, again=options.again))
            if checkers:
                run.fault(name, checkers)
    clean = {name: run.work / "bases" / name for name in NAMES}
    clean |= {path.resolve().name: path.resolve() for path in options.clean}
    for name, dataset in clean.items() if CLEAN in wanted else ():
        run.clean(name, dataset, list(run.missing(name, again=options.again)))
    rows, summary = list(run.rows.values()), options.out / "checkers.json"
    before = read_json(summary) if summary.is_file() else {"seconds": {}, "versions": {}}
    seconds = before["seconds"] | (run.seconds() if not options.faults else {})
    reached = figures(rows, seconds.get(OWN))
    for figure in reached:
        show(figure)
    more = {
        "groups": by_group(rows), "alarms": alarms(rows), "found_by_lfr_alone": only(rows),
        "seconds": seconds, "versions": before["versions"] | run.versions, "not_run": run.refused,
    }  # fmt: skip
    print(write("checkers", reached, options.out, more))


def _names(text: str) -> list[str]:
    return text.split(",")


def _check(kind: str, names: list[str] | None, known: Collection[str]) -> None:
    for name in names or ():
        if name not in known:
            raise UnknownNameError(kind, name, known)


if __name__ == "__main__":
    sys.exit(main())
