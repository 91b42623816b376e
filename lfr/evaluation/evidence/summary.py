"""One method on one transfer under one reward, over all its seeds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from lfr.evaluation.evidence.aggregate import (
    Interval,
    bootstrap,
    improvement,
    interquartile_mean,
    mean,
)
from lfr.evaluation.evidence.curves import LEVELS, median_first
from lfr.evaluation.evidence.records import Evidence, SeedRun, counts

OURS = "lfr"


@dataclass(frozen=True)
class Summary:
    """Success and speed of a method over its seeds.

    Attributes:
        reward: of the block that it is shown in, also where the method itself has none.
        seeds, rates: a held-out rate per seed.
        mean, iqm: of the rates, with their bootstrap intervals.
        zero_shot, stock, auc: means over seeds; None where it is not measured.
        env_steps: of the longest run.
        steps_to: median over seeds for each of `LEVELS`, None where most seeds never reach it;
            empty without curves.
        improvement: P(LfR > this method); None of LfR itself and where LfR has no run.
    """

    transfer: str
    method: str
    reward: str
    seeds: tuple[int, ...]
    rates: tuple[float, ...]
    mean: Interval
    iqm: Interval
    zero_shot: float | None
    stock: float | None
    auc: float | None
    env_steps: int | None
    steps_to: tuple[float | None, ...]
    improvement: Interval | None


def summarise(evidence: Evidence, transfer: str, method: str, reward: str) -> Summary | None:
    """A method's summary; None where none of its seeds is there yet."""
    runs, ours = (evidence.of(transfer, name, reward) for name in (method, OURS))
    if not runs:
        return None
    found = counts(runs)
    compared = method != OURS and bool(ours)
    return Summary(
        transfer=transfer,
        method=method,
        reward=reward,
        seeds=tuple(run.seed for run in runs),
        rates=tuple(run.success for run in runs),
        mean=bootstrap([found], mean),
        iqm=bootstrap([found], interquartile_mean),
        zero_shot=_mean(run.zero_shot for run in runs),
        stock=_mean(run.stock for run in runs),
        auc=_mean(run.auc for run in runs),
        env_steps=max((run.env_steps for run in runs if run.env_steps is not None), default=None),
        steps_to=_medians(runs),
        improvement=improvement([counts(ours)], [found]) if compared else None,
    )


def summaries(evidence: Evidence, transfers: Iterable[str]) -> list[Summary]:
    """Every method that is there, transfer by transfer and reward by reward."""
    found = (
        summarise(evidence, transfer, method, reward)
        for transfer in transfers
        for reward in evidence.rewards()
        for method in evidence.methods([transfer])
    )
    return [one for one in found if one]


def first_starts(evidence: Evidence) -> str:
    """On how many of the first starts robosuite judged: ``25``."""
    judged = {run.stock_episodes for run in evidence.runs if run.stock_episodes is not None}
    return " or ".join(map(str, sorted(judged))) or "0"


def as_metrics(found: Iterable[Summary]) -> dict[str, Any]:
    """transfer -> method -> reward -> numbers: what tables.json holds and DVC compares."""
    metrics: dict[str, Any] = {}
    for one in found:
        numbers = {
            "seeds": len(one.seeds),
            "rates": dict(zip(map(str, one.seeds), one.rates, strict=True)),
            "mean": one.mean,
            "iqm": one.iqm,
            "zero_shot": one.zero_shot,
            "stock": one.stock,
            "auc": one.auc,
            "env_steps": one.env_steps,
            "steps_to": {
                f"{level:.2f}": steps
                for level, steps in zip(LEVELS, one.steps_to, strict=False)
            },
            "lfr_better": one.improvement,
        }  # fmt: skip
        metrics.setdefault(one.transfer, {}).setdefault(one.method, {})[one.reward] = numbers
    return metrics


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return fmean(known) if known else None


def _medians(runs: list[SeedRun]) -> tuple[float | None, ...]:
    firsts = [run.steps_to for run in runs if run.curve]
    return tuple(median_first(at_level) for at_level in zip(*firsts, strict=True))
