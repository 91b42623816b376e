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
    learned = {run.key[:6]: run.env_steps for run in runs() if run.env_steps}
    assert set(learned) == curves
    for curve, last in learned.items():
        steps = [one.env_steps for one in read_curves(RESULTS / "curves.csv") if one.key == curve]
        assert steps == sorted(set(steps)), curve
        assert (steps[0], steps[-1]) == (0, last), curve


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
    assert says("After 40,000 steps it is {}, {}, {} and {} %".format(*_all("lfr", learned=True)))
    before, after = (_by_seed(STACK_SAWYER, "lfr", learned=learned) for learned in (False, True))
    assert says(
        f"Sawyer's Stack begins between {min(before)} and {max(before)} by seed and ends between "
        f"{min(after)} and {max(after)}"
    )
    before, after = (_by_seed(CAN, "lfr", learned=learned) for learned in (False, True))
    assert says(
        f"the can begins between {min(before)} and {max(before)} and ends at {min(after)} in all "
        "five"
    )
    assert len(set(after)) == 1


def test_what_lfr_is_above_after_learning() -> None:
    stack, can, oracle = (
        _above(STACK_SAWYER, "retarget"), _above(CAN, "retarget"), _above(STACK_SAWYER, "oracle"),
    )  # fmt: skip
    assert says(f"LfR ends {stack.mean} and {can.mean} points above retargeting")
    assert says(f"on Sawyer's Stack {oracle.mean} above the target's own policy from its own "
                f"demonstrations ({mean(STACK_SAWYER, 'oracle')})")  # fmt: skip
    assert min(stack.low, can.low, oracle.low) > 0
    assert says("Elsewhere it is not told apart from either.")
    for transfer, method in (
        *((one, other) for one in (LIFT, STACK_PANDA) for other in ("retarget", "oracle")),
        (CAN, "oracle"),
    ):
        found = _above(transfer, method)
        assert found.low <= 0 <= found.high, (transfer, method)


def test_what_is_lost_before_the_mapping() -> None:
    theirs, ours = (
        ", ".join(map(str, _by_seed(STACK_SAWYER, method))) for method in ("retarget", "lfr")
    )
    assert says(
        f"Retargeting has {mean(STACK_SAWYER, 'retarget')} % on Sawyer's Stack ({theirs} by seed; "
        f"LfR {ours})"
    )
    g, retarget = (chosen(runs(), CAN, method) for method in ("lfr", "retarget"))
    more = difference(g.outcomes, retarget.outcomes)
    assert says(f"On the can it has {mean(CAN, 'retarget')}, and G, which speaks in skills of the "
                f"target's own, {100 * more.mean:.0f} points more")  # fmt: skip
    assert more.low > 0
    assert says(f"and began at 62 % instead of {mean(CAN, 'lfr')}")


def test_beside_the_paper() -> None:
    after = dict(zip(PAPERS, _all("lfr", learned=True), strict=True))
    for transfer, words in (
        (LIFT, "Lift {} (the paper {:.0f})"), (STACK_SAWYER, "Sawyer's Stack {} ({:.0f})"),
        (STACK_PANDA, "Panda's {} ({})"), (CAN, "the can {} ({})"),
    ):  # fmt: skip
        first = chosen(runs(), transfer, "lfr").runs[0]
        theirs = PAPER[first.task, first.target]["lfr"]
        assert says(words.format(after[transfer], theirs))
        assert after[transfer] > theirs


def _by_seed(transfer: str, method: str, *, learned: bool = False) -> list[int]:
    return [run.successes for run in chosen(runs(), transfer, method, learned=learned).runs]


def _all(method: str, *, learned: bool = False) -> list[int]:
    return [mean(transfer, method, learned=learned) for transfer in PAPERS]


def _above(transfer: str, method: str) -> Interval:
    """How many points LfR after learning is above a method that has not learned."""
    after, other = chosen(runs(), transfer, "lfr", learned=True), chosen(runs(), transfer, method)
    return Interval(*(round(100 * one) for one in difference(after.outcomes, other.outcomes)))
