"""Stage report: tables, figure and text from what the other stages left under results/."""

import sys
from pathlib import Path

from lfr.artifacts import write_json, write_whole
from lfr.errors import ParameterError
from lfr.evaluation import figures
from lfr.evaluation import results_tables as tables
from lfr.evaluation.marked import put
from lfr.evaluation.readme import MARKER, results_block
from lfr.evaluation.records import RESULTS, chain_records, read_runs, transfer_records
from lfr.evaluation.results_page import report
from lfr.external import external
from lfr.params import PARAMS, read_names
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named

README = Path("README.md")


def main() -> None:
    """Gather results/transfers.json, chain.json, the table, learning.svg and report.md.

    The README, where there is one, shows the figure and the table.
    """
    transfers, methods = _listed("transfers"), _listed("methods")
    for name in transfers:
        transfer_named(name)
    runs = read_runs(transfers, methods)
    records, chains = transfer_records(runs), chain_records(transfers)
    curves = {
        (run.learned["transfer"], run.learned["method"]): figures.read_curves(_curves(run.learned))
        for run in runs
    }
    warm_up = max(run.learned["warm_up"] for run in runs)
    write_json(RESULTS / "transfers.json", records)
    write_json(RESULTS / "chain.json", chains)
    figures.learning_figure(RESULTS / "learning.svg", curves, records, warm_up)
    write_json(RESULTS / "table.json", tables.summary(records, chains))
    _write(RESULTS / "table.md", tables.headline_table(records, chains))
    _write(RESULTS / "report.md", report(records, chains, external=external().transfers))
    if README.is_file():  # it is no output of the stage, and need not be there
        put(README, MARKER, results_block())


def _listed(section: str) -> list[str]:
    names = read_names(section)
    if not names:
        raise ParameterError(f"{PARAMS}: {section}: names nothing that a report could be of")
    return names


def _curves(learned: dict[str, str]) -> Path:
    return RESULTS / "transfer" / f"{learned['transfer']}-{learned['method']}.csv"


def _write(path: Path, text: str) -> None:
    with write_whole(path) as partial:
        partial.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(run_stage(main))
