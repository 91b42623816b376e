"""What this work set itself to reach, against what was reached; and who is not below LfR."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lfr.evaluation.evidence.aggregate import Interval, Place, bootstrap, difference
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.pairs import NO_LEARNING, no_learning, pairs
from lfr.evaluation.evidence.published import (
    ABLATIONS,
    BASELINES,
    PUBLISHED,
    SCENARIO_2,
    TASKS,
)
from lfr.evaluation.evidence.records import Evidence, SeedRun, counts
from lfr.evaluation.evidence.summary import OURS, Summary, summarise
from lfr.evaluation.evidence.tables import DASH, percent, percent_interval
from lfr.evaluation.tables import markdown

# who learns besides the paper's methods, and where: what it ablates, as paper/params.yaml has it
QUESTIONS = ("spirl", "spirl_no_prior", "shared_vae", "wrong_task")
QUESTIONED = {(transfer, "sparse") for transfer in SCENARIO_2}
EXACT = 1e-9  # a mean of hundredths is not exact
OVERSHOOT = 100  # environment steps: a run ends with the skills under way in each simulation
MARK = "†"  # not below LfR by interquartile means, yet LfR's mean is higher by its interval


@dataclass(frozen=True)
class Target:
    """Success to reach, mean over seeds, and environment steps to reach it in."""

    success: float
    env_steps: int


TARGETS = {
    "s1-panda-lift": Target(0.99, 10_000),
    "s1-sawyer-stack": Target(0.98, 100_000),
    "s2-panda-stack": Target(0.98, 100_000),
    "s2-sawyer-pick_place": Target(0.97, 50_000),
}


@dataclass(frozen=True)
class Rival:
    """Somebody beside LfR, over the seeds that both have.

    Attributes:
        theirs, ours: intervals of the interquartile means.
        lead: LfR's mean less theirs, with its interval.
    """

    theirs: Interval
    ours: Interval
    lead: Interval

    @property
    def mark(self) -> str:
        """`MARK` where it is not below LfR and yet LfR's mean is higher by its interval: of five
        seeds the interquartile mean does not see a single one that fails."""
        return MARK if self.lead.low > 0 and self.place != "below" else ""

    @property
    def place(self) -> Place:
        """Where theirs lies beside LfR's."""
        return self.theirs.beside(self.ours)


@dataclass(frozen=True)
class Standing:
    """LfR's interval of the interquartile mean against everybody else's, on one transfer.

    Attributes:
        ours: LfR's, of all its seeds.
        below, level, above: those whose interval lies wholly below LfR's of the same seeds,
            overlaps or touches it, or lies wholly above it; by their labels.
    """

    ours: Interval
    below: dict[str, Rival]
    level: dict[str, Rival]
    above: dict[str, Rival]

    @property
    def in_the_way(self) -> dict[str, Rival]:
        """Those that keep LfR from being above everybody."""
        return {**self.above, **self.level}

    @property
    def named(self) -> str:
        """Those in the way, with `MARK` where it applies; empty if nobody is."""
        return ", ".join(f"{name}{rival.mark}" for name, rival in self.in_the_way.items())


def standing(evidence: Evidence, transfer: str, reward: str) -> Standing | None:
    """Where LfR stands; None before it has a run.

    Compared are all methods that learn under the same reward or none, but for LfR's own ablations,
    and those zero-shot links that are no variants of its G: `NO_LEARNING`. No oracle is.
    """
    runs = evidence.of(transfer, OURS, reward)
    if not runs:
        return None
    own = {method_label(method) for method in evidence.methods([transfer])
           if method == OURS or method in ABLATIONS or method.startswith("only_")}  # fmt: skip
    places: dict[str, dict[str, Rival]] = {"below": {}, "level": {}, "above": {}}
    for name, pair in pairs(evidence, transfer, reward).items():
        if name not in own:
            lead = difference([pair.ours], [pair.theirs])
            rival = Rival(bootstrap([pair.theirs]), bootstrap([pair.ours]), lead)
            places[rival.place][name] = rival
    return Standing(bootstrap([counts(runs)]), **places)


def expected_rivals(transfer: str, reward: str) -> list[str]:
    """The labels of those whom LfR has to be compared with there."""
    questions = QUESTIONS if (transfer, reward) in QUESTIONED else ()
    return [*map(method_label, (*BASELINES, *questions)), *map(no_learning, NO_LEARNING)]


def steps_to_goal(runs: list[SeedRun], goal: float) -> float | None:
    """Environment steps until the mean over seeds is at the goal; None if it never is.

    0 where the held-out rates before learning are there; otherwise the first running evaluation,
    of a few starts per seed, whose mean is. Seeds are evaluated a few steps apart, by the skills
    under way: the steps are those of the last one.
    """
    before = [run.zero_shot for run in runs if run.zero_shot is not None]
    if len(before) == len(runs) and np.mean(before) >= goal - EXACT:
        return 0.0
    curves = [run.curve for run in runs if run.curve]
    steps = zip(*(curve.env_steps[1:] for curve in curves), strict=False)
    rates = zip(*(curve.success[1:] for curve in curves), strict=False)
    for at, found in zip(steps, rates, strict=True):
        if np.mean(found) >= goal - EXACT:
            return float(max(at))
    return None


def targets_table(evidence: Evidence) -> str:
    """Every target under every reward: reached or not, how soon, and who stands in the way."""
    header = ["task", "reward", "paper", "goal", "mean", "IQM", "n", "reached", "in steps",
              "reached in", "in time", "above every other", "not below LfR"]  # fmt: skip
    rows = [
        [TASKS[transfer], reward, f"{PUBLISHED[transfer, OURS].rate:.1f}",
         f"{100 * target.success:.0f}", *_reached(evidence, transfer, reward, target)]
        for transfer, target in TARGETS.items()
        for reward in evidence.rewards()
    ]  # fmt: skip
    return markdown(header, rows)


def _reached(evidence: Evidence, transfer: str, reward: str, target: Target) -> list[object]:
    ours = summarise(evidence, transfer, OURS, reward)
    place = standing(evidence, transfer, reward)
    if ours is None or place is None:
        return [DASH, DASH, 0, DASH, target.env_steps, DASH, DASH, DASH, DASH]
    there = reached(ours, target)
    steps = steps_to_goal(evidence.of(transfer, OURS, reward), target.success)
    in_time = there and in_budget(ours, steps, target)
    known = {**place.in_the_way, **place.below}
    whole = known.keys() >= set(expected_rivals(transfer, reward))
    above = "no" if place.in_the_way else "yes" if whole else "so far" if known else DASH
    return [percent(ours.mean.value), percent_interval(ours.iqm), len(ours.seeds), _yes(there),
            target.env_steps, "never" if steps is None else f"{steps:.0f}", _yes(in_time),
            above, place.named or DASH]  # fmt: skip


def reached(ours: Summary, target: Target) -> bool:
    """Whether the mean over seeds of the final held-out rates is at the goal."""
    return ours.mean.value >= target.success - EXACT


def in_budget(ours: Summary, steps: float | None, target: Target) -> bool:
    """Whether the goal was met in time: the whole run is that short, or its curve got there."""
    within = target.env_steps + OVERSHOOT
    return (ours.env_steps or 0) <= within or (steps is not None and steps <= within)


def _yes(true: bool) -> str:
    return "yes" if true else "no"
