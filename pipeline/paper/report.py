"""Stage report of the evidence: tables, figures and text from what is under results/paper."""

import sys
from pathlib import Path

from lfr.artifacts import write_json, write_whole
from lfr.evaluation.evidence.figures import FIGURES, curve_figure
from lfr.evaluation.evidence.headline import headline_figure
from lfr.evaluation.evidence.published import TABLES, TASKS
from lfr.evaluation.evidence.readme import evidence_block, update_evidence
from lfr.evaluation.evidence.records import PAPER, read_evidence
from lfr.evaluation.evidence.reference import reference_figure
from lfr.evaluation.evidence.report import report
from lfr.evaluation.evidence.summary import as_metrics, summaries
from lfr.evaluation.evidence.tables import paper_table, questions_table
from lfr.program import run_stage

README = Path("README.md")


def main() -> None:
    """Write results/paper's tables, figures, tables.json and report.md of what is there so far.

    The README, where there is one, shows the headline.
    """
    evidence = read_evidence()
    for name, table in TABLES.items():
        _write(f"{name}.md", paper_table(table, evidence))
    _write("questions.md", questions_table(evidence))
    for name, figure in FIGURES.items():
        curve_figure(PAPER / f"{name}.svg", figure, evidence)
    headline_figure(PAPER / "headline.svg", evidence)
    if evidence.reference:
        reference_figure(PAPER / "reference.svg", evidence.reference)
    write_json(PAPER / "tables.json", as_metrics(summaries(evidence, TASKS)))
    _write("report.md", report(evidence))
    if README.is_file():  # it is no output of the stage, and need not be there
        update_evidence(README, evidence_block())


def _write(name: str, text: str) -> None:
    with write_whole(PAPER / name) as partial:
        partial.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(run_stage(main))
