"""docs/evidence.md is held to the table of all runs: its tables and its sentences."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from lfr.evaluation.marked import shown
from studies.evidence.page import tables_of
from studies.evidence.runs import Run, read_curves, read_runs
from studies.evidence.tables import PAPERS, TABLES, chosen

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs/evidence.md"
RESULTS = ROOT / "results/evidence"
LIFT, STACK_SAWYER, STACK_PANDA, CAN = PAPERS


@cache
def runs() -> list[Run]:
    return read_runs(RESULTS / "runs.csv")


def mean(transfer: str, method: str, *, learned: bool = False) -> int:
    """Percent, rounded as the page does."""
    return round(100 * chosen(runs(), transfer, method, learned=learned).interval.mean)


def says(sentence: str) -> bool:
    """Whether the page has it, however its lines are broken."""
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    return " ".join(sentence.split()) in text


@pytest.mark.parametrize("name", tables_of(PAGE))
def test_a_table_is_computed_from_the_runs(name: str) -> None:
    again = "run `python -m studies.evidence.page`"
    assert shown(PAGE, name) == TABLES[name](runs()).strip(), again


def test_every_run_can_be_traced() -> None:
    for run in runs():
        assert re.fullmatch(r"[0-9a-f]{40}", run.revision), run
        assert run.processor
        assert run.starts == len(run.outcomes) == {"engine": 100, "robosuite": 25}[run.judge]
        assert run.successes == run.outcomes.count("1")
        assert bool(run.reward) == bool(run.env_steps)
    assert len({run.key for run in runs()}) == len(runs())


def test_every_run_that_learned_has_its_curve() -> None:
    curves = {point.key[:6] for point in read_curves(RESULTS / "curves.csv")}
    learned = {run.key[:6] for run in runs() if run.env_steps}
    assert learned == curves


def test_seeds_are_whole() -> None:
    for transfer in {run.transfer for run in runs()}:
        methods = {(run.method, run.env_steps > 0) for run in runs() if run.transfer == transfer}
        for method, learned in methods:
            found = chosen(runs(), transfer, method, learned=learned)
            assert found.seeds == tuple(range(5)), (transfer, method)
