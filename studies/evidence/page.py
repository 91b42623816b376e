"""`python -m studies.evidence.page`: tables and figures of docs/evidence.md, from the runs."""

from __future__ import annotations

import sys
from pathlib import Path

from lfr.evaluation.marked import put
from lfr.program import run_stage
from studies.evidence.figures import learning_figure, matrix_figure
from studies.evidence.runs import RESULTS, read_curves, read_runs
from studies.evidence.tables import TABLES, matrix_arms

PAGE = Path("docs/evidence.md")


def main() -> None:
    """Write the tables into docs/evidence.md, and the figures beside results/evidence/runs.csv."""
    runs = read_runs()
    for name in tables_of(PAGE):
        put(PAGE, name, TABLES[name](runs).strip())
    learning_figure(RESULTS / "learning.svg", runs, read_curves())
    if matrix_arms(runs):
        matrix_figure(RESULTS / "matrix.svg", runs)


def tables_of(page: Path) -> list[str]:
    """Those that a page has a place for."""
    text = page.read_text(encoding="utf-8")
    return [name for name in TABLES if f"<!-- {name} -->" in text]


if __name__ == "__main__":
    sys.exit(run_stage(main))
