"""Success rates of policies on held-out starts: shards of seeds are jobs, whatever the policy."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lfr.errors import UnknownNameError
from lfr.evaluation.statistics import success_of
from lfr.jobs import run_jobs
from lfr.policies import Outcome, PolicySource, Simulated, roll_out
from lfr.seeds import episode_seed

JudgeName = Literal["engine", "robosuite"]
SHARD = 25  # episodes of a job: seconds of work, so that a kill costs little


@dataclass(frozen=True)
class Trial:
    """A policy on one arm and task, over the held-out starts ``first`` to ``first + episodes``."""

    policy: PolicySource
    robot: str
    task: str
    episodes: int
    judge: JudgeName = "engine"
    first: int = 0


def success_rates(
    trials: Mapping[str, Trial], work: Path, description: str
) -> dict[str, dict[str, Any]]:
    """Each trial's successes, Wilson interval and mean length of a successful episode."""
    shards = named_shards(trials)
    jobs = [shard for _, shard in shards]
    done = run_jobs(run_trial, jobs, work=work, description=description, unit="shard")
    return summaries([name for name, _ in shards], done)


def named_shards(trials: Mapping[str, Trial]) -> list[tuple[str, Trial]]:
    """All trials in pieces, each with its trial's name."""
    return [(name, shard) for name, trial in trials.items() for shard in shards_of(trial)]


def summaries[Name: Hashable](
    names: Sequence[Name], done: Sequence[Any]
) -> dict[Name, dict[str, Any]]:
    """What `run_trial` gave for each shard, put together by the names of their trials."""
    outcomes: dict[Name, list[Outcome]] = {name: [] for name in names}
    for name, result in zip(names, done, strict=True):
        outcomes[name] += [Outcome(**outcome) for outcome in result]
    return {name: summary(found) for name, found in outcomes.items()}


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Success with its Wilson interval, and control steps until success."""
    lengths = [outcome.steps for outcome in outcomes if outcome.success]
    success = success_of(len(lengths), len(outcomes))
    return {**vars(success), "steps": float(np.mean(lengths)) if lengths else None}


def shards_of(trial: Trial) -> list[Trial]:
    """The trial in pieces of at most `SHARD` episodes."""
    end = trial.first + trial.episodes
    return [
        replace(trial, first=first, episodes=min(SHARD, end - first))
        for first in range(trial.first, end, SHARD)
    ]


def run_trial(trial: Trial) -> list[Outcome]:
    """Run a trial's episodes one after the other, in this process."""
    end = trial.first + trial.episodes
    seeds = [episode_seed("held-out", index) for index in range(trial.first, end)]
    return roll_out(trial.policy.load(), judge_named(trial.judge, trial.robot, trial.task), seeds)


@cache
def judge_named(name: JudgeName, robot: str, task: str) -> Simulated:
    """The simulation that judges: the engine, or stock robosuite; kept for the next trial.

    Raises:
        UnknownNameError: there is no such judge.
    """
    if name == "engine":
        from lfr.sim.simulation import simulation

        return simulation(robot, task)
    if name == "robosuite":
        from lfr.sim.stock import StockSimulation

        return StockSimulation(robot, task)
    raise UnknownNameError("judge", name, ("engine", "robosuite"))
