"""`python -m studies.evidence.page`: tables and figures of docs/evidence.md, from the runs."""

from __future__ import annotations

import sys
from pathlib import Path

from lfr.evaluation.marked import put
from lfr.program import run_stage
from studies.evidence.figures import learning_figure, matrix_figure
from studies.evidence.runs import RESULTS, read_curves, read_runs
from studies.evidence.tables import TABLES

PAGE = Path("docs/evidence.md")


def main() -> None:
    """Write the tables into docs/evidence.md, and the figures beside results/evidence/runs.csv."""
    runs = read_runs()
    for name, table in TABLES.items():
        put(PAGE, name, table(runs).strip())
    learning_figure(RESULTS / "learning.svg", runs, read_curves())
    matrix_figure(RESULTS / "matrix.svg", runs)


if __name__ == "__main__":
    sys.exit(run_stage(main))
