"""docs/evidence.md is held to the table of all runs: its tables and its sentences."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from lfr.evaluation.marked import shown
from studies.evidence.page import tables_of
from studies.evidence.runs import Run, read_curves, read_runs
from studies.evidence.statistics import Interval, difference
from studies.evidence.tables import PAPER, PAPERS, TABLES, chosen

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


def test_nothing_carries_over_by_itself() -> None:
    found = [run for transfer in PAPERS for method in ("identity", "no_generator")
             for run in chosen(runs(), transfer, method).runs]  # fmt: skip
    successes, starts = (sum(getattr(run, of) for run in found) for of in ("successes", "starts"))
    assert says(f"succeed in {successes} of {starts:,} episodes")
    assert says("{}, {}, {} and {} % before any learning".format(*_all("lfr")))


def test_what_a_linear_map_has() -> None:
    of_can = [run.successes for run in chosen(runs(), CAN, "linear").runs]
    rates = "{}, {}, {} and {} %".format(*_all("linear"))
    assert says(f"has {rates}, and on the can from {min(of_can)} to {max(of_can)} by seed")


def test_what_learning_adds() -> None:
    gains = {one: _above(one, "lfr") for one in PAPERS}
    assert says(
        f"{gains[STACK_SAWYER].mean} points on Sawyer's Stack and {gains[CAN].mean} on the can"
    )
    beyond = {one: _above(one, "retarget") for one in (STACK_SAWYER, CAN)}
    assert says(
        f"LfR is {beyond[STACK_SAWYER].mean} and {beyond[CAN].mean} points above retargeting"
    )
    assert all(one.low >= 0 for one in (*beyond.values(), gains[STACK_SAWYER], gains[CAN]))
    for transfer in (LIFT, STACK_PANDA):
        assert (mean(transfer, "lfr") >= 89, gains[transfer].mean) == (True, 1)


def test_what_is_lost_before_the_mapping() -> None:
    rates = mean(STACK_SAWYER, "retarget"), mean(STACK_SAWYER, "oracle")
    assert says("retargeting has {} % as well, and the target shown the task {}".format(*rates))
    pairs = zip(_all("recoded"), _all("retarget"), strict=True)
    assert max(abs(first - second) for first, second in pairs) == 4


def test_beside_the_paper() -> None:
    after = dict(zip(PAPERS, _all("lfr", learned=True), strict=True))
    for transfer, words in (
        (CAN, "on the can ({}, the paper {})"), (LIFT, "Lift ({}, {:.0f})"),
        (STACK_PANDA, "on Panda's Stack ({}, {})"), (STACK_SAWYER, "on Sawyer's ({}, {:.0f})"),
    ):  # fmt: skip
        first = chosen(runs(), transfer, "lfr").runs[0]
        assert says(words.format(after[transfer], PAPER[first.task, first.target]["lfr"]))


def _all(method: str, *, learned: bool = False) -> list[int]:
    return [mean(transfer, method, learned=learned) for transfer in PAPERS]


def _above(transfer: str, method: str) -> Interval:
    """How many points LfR after learning is above a method that has not learned."""
    after, other = chosen(runs(), transfer, "lfr", learned=True), chosen(runs(), transfer, method)
    return Interval(*(round(100 * one) for one in difference(after.outcomes, other.outcomes)))
