"""The table of docs/trust.md, and what is said below it, from results/benchmarks/checkers.csv."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks._figures import FOLDER
from benchmarks.checkers.peers import CHECKERS, OWN
from benchmarks.checkers.results import (
    Row,
    alarms,
    by_group,
    complete,
    not_found,
    only,
    read_rows,
    total,
)
from lfr.artifacts import read_json
from lfr.evaluation.marked import put

PAGE, MARKER = Path("docs/trust.md"), "checkers"
ROWS, SUMMARY = FOLDER / "checkers.csv", FOLDER / "checkers.json"

COLUMNS = {
    "rows": ("values", "order", "time"),
    "meta": ("counts", "schema", "statistics", "tasks", "outcome"),
    "files": ("files", "log", "hostile"),
    "videos": ("video", "pictures"),
    "behaviour": ("behaviour",),
}
"""The table's columns, of which each is some groups of faults."""


def page() -> None:
    """Write the table into the page."""
    put(PAGE, MARKER, shown_on_page())


def shown_on_page() -> str:
    """What stands there, of those checkers that have been given every fault."""
    rows, summary = read_rows(ROWS), read_json(SUMMARY)
    whole = complete(rows)
    apart = sorted({row.checker for row in rows} - {row.checker for row in whole})
    not_run = {name: "not yet given every fault" for name in apart} | summary["not_run"]
    why = "; ".join(f"{name} ({reason})" for name, reason in not_run.items())
    return f"{table(whole, summary)}\n\nNot in the table: {why}."


def table(rows: Sequence[Row], summary: Mapping[str, Any]) -> str:
    """Faults found by each checker, the best first, and what only one has found and what not."""
    groups, said = by_group(rows), alarms(rows)
    order = sorted(groups, key=lambda name: (-total(groups[name])[0], name))
    lines = [
        f"| checker | found | {' | '.join(COLUMNS)} | clean datasets of which it says something "
        "| CPU s for 1,000 episodes |",
        f"|---|{'---|' * (len(COLUMNS) + 3)}",
    ]
    for name in order:
        parts = [_sum(groups[name], column) for column in COLUMNS.values()]
        seconds = summary["seconds"].get(name)
        cells = [
            _called(name, summary["versions"]), _of(total(groups[name])), *map(_of, parts),
            _of(said[name]), "-" if seconds is None else f"{seconds:.1f}",
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    alone, missed = only(rows), not_found(rows)
    return "\n".join([
        *lines, "",
        f"Found by `lfr verify` and by no other ({len(alone)}): {_named(alone)}.", "",
        f"Not found by it ({len(missed)}): {_named(missed)}.",
    ])  # fmt: skip


def _sum(groups: Mapping[str, tuple[int, int]], names: Sequence[str]) -> tuple[int, int]:
    return total({name: groups[name] for name in names if name in groups})


def _of(count: tuple[int, int]) -> str:
    return f"{count[0]} of {count[1]}"


def _called(name: str, versions: Mapping[str, str]) -> str:
    if name == OWN:
        return "**`lfr verify`**"
    package = CHECKERS[name].package.split("[")[0] if name in CHECKERS else name
    return f"{package} {versions.get(name, '')}".strip()


def _named(faults: Sequence[str]) -> str:
    return ", ".join(fault.replace("_", " ") for fault in faults) or "none"


if __name__ == "__main__":
    page()
