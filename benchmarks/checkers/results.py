"""The table of results: a row for each fault and checker, and what is counted of the rows."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from benchmarks.checkers.faults import CONTROL, FAULTS, GROUPS
from benchmarks.checkers.findings import Said
from benchmarks.checkers.peers import OWN
from lfr.artifacts import write_whole

CLEAN = "clean"
"""The group of datasets in which nothing is wrong, and the rows that count what is said of them."""

FOUND, OTHER, MISSED, CRASH = "found", "other", "missed", "crash"


@dataclass(frozen=True)
class Row:
    """What a checker made of a fault.

    Attributes:
        fault, group: of `benchmarks.checkers.faults.FAULTS`, or a clean dataset's name, "clean".
        checker, version: which; of this project a fingerprint of the code.
        result: `found`, it says something that it does not say of the clean dataset, in words that
            fit; `other`, only in words that do not; `missed`, it says nothing more; `crash`. Of a
            clean dataset: `found` where it says something, else `missed`.
        finding: one of the lines; of a crash how it ended; of a clean dataset how many and the
            first.
    """

    fault: str
    group: str
    checker: str
    version: str
    result: str
    finding: str = ""


def judged(name: str, checker: str, version: str, clean: Said, found: Said) -> Row:
    """The row of a fault, from what is said of the clean dataset and of the one with the fault."""
    fault = FAULTS[name]
    if found.crash:
        return Row(name, fault.group, checker, version, CRASH, found.crash)
    new = sorted(found.lines - clean.lines)
    if fault.group == CONTROL:  # nothing should be said
        return Row(name, fault.group, checker, version, OTHER if new else MISSED, *new[:1])
    fit = [line for line in new if re.search(fault.fits, line, re.IGNORECASE)]
    result = FOUND if fit else OTHER if new else MISSED
    return Row(name, fault.group, checker, version, result, *(fit or new)[:1])


def of_clean(name: str, checker: str, version: str, said: Said) -> Row:
    """The row of a dataset in which nothing is wrong."""
    if said.crash:
        return Row(name, CLEAN, checker, version, CRASH, said.crash)
    lines = sorted(said.lines)
    finding = f"{len(lines)}: {lines[0]}" if lines else ""
    return Row(name, CLEAN, checker, version, FOUND if lines else MISSED, finding)


def detected(row: Row) -> bool:
    """Whether it counts as found: of this project in words that fit, of others in any."""
    return row.result == FOUND or (row.result == OTHER and row.checker != OWN)


def read_rows(file: Path) -> list[Row]:
    """The rows that there are already."""
    if not file.is_file():
        return []
    with file.open(newline="", encoding="utf-8") as stream:
        return [Row(**row) for row in csv.DictReader(stream)]


def write_rows(file: Path, rows: Iterable[Row]) -> None:
    """Write the table, in the order of the faults and, of each, of the checkers' names."""
    order = {name: place for place, name in enumerate(FAULTS)}
    ordered = sorted(rows, key=lambda r: (order.get(r.fault, len(order)), r.fault, r.checker))
    with write_whole(file) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [f.name for f in fields(Row)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) | {"finding": row.finding[:160]} for row in ordered)


def by_group(rows: Iterable[Row]) -> dict[str, dict[str, tuple[int, int]]]:
    """Of each checker and group: how many faults it has found, and of how many."""
    counts: dict[str, dict[str, tuple[int, int]]] = {}
    for row in rows:
        if row.group in GROUPS and row.group != CONTROL:
            of_checker = counts.setdefault(row.checker, {})
            found, all = of_checker.get(row.group, (0, 0))
            of_checker[row.group] = found + detected(row), all + 1
    return counts


def total(groups: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Found, and of how many, over all groups."""
    return sum(f for f, _ in groups.values()), sum(n for _, n in groups.values())


def alarms(rows: Iterable[Row]) -> dict[str, tuple[int, int]]:
    """Of each checker: of how many clean datasets it says something, a crash too; of how many.

    A control counts as one: a dataset that was rewritten, and of which more is said than before.
    """
    counts: dict[str, tuple[int, int]] = {}
    for row in rows:
        if row.group in (CLEAN, CONTROL):
            found, all = counts.get(row.checker, (0, 0))
            counts[row.checker] = found + (row.result != MISSED), all + 1
    return counts


def complete(rows: Iterable[Row]) -> list[Row]:
    """The rows of those checkers that have been given every fault."""
    faults: dict[str, set[str]] = {}
    rows = list(rows)
    for row in rows:
        faults.setdefault(row.checker, set()).add(row.fault)
    return [row for row in rows if faults[row.checker] >= FAULTS.keys()]


def only(rows: Iterable[Row], checker: str = OWN) -> list[str]:
    """Faults that this checker alone has found."""
    finders: dict[str, set[str]] = {}
    for row in rows:
        if row.group in GROUPS and row.group != CONTROL and detected(row):
            finders.setdefault(row.fault, set()).add(row.checker)
    return [fault for fault, who in finders.items() if who == {checker}]


def not_found(rows: Iterable[Row], checker: str = OWN) -> list[str]:
    """Faults that this checker has not found."""
    return [
        row.fault
        for row in rows
        if row.checker == checker
        and row.group in GROUPS
        and row.group != CONTROL
        and not detected(row)
    ]
