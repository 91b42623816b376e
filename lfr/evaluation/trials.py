"""Success rates of policies on held-out starts: shards of seeds are jobs, whatever the policy."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lfr.environments.simulation import ExternalTarget
from lfr.errors import UnknownNameError
from lfr.evaluation.success_rate import success_of
from lfr.jobs import Job, run_jobs
from lfr.policies import Outcome, PolicySource, Simulated, roll_out
from lfr.seeds import episode_seed

Simulator = Literal["engine", "robosuite"]
JudgeName = Simulator | Literal["environment"]
SHARD = 25  # episodes of a job: seconds of work, so that a kill costs little


@dataclass(frozen=True)
class Trial:
    """A policy on one arm and task, over the held-out starts ``first`` to ``first + episodes``.

    Attributes:
        external: the environment of an arm that is not simulated here, which is the judge then.
    """

    policy: PolicySource
    robot: str
    task: str
    episodes: int
    judge: JudgeName = "engine"
    first: int = 0
    external: ExternalTarget | None = None


def success_rates(
    trials: Mapping[str, Trial], work: Path, description: str
) -> dict[str, dict[str, Any]]:
    """Each trial's successes, Wilson interval and mean length of a successful episode."""
    shards = {name: trial_jobs(trial) for name, trial in trials.items()}
    done = run_jobs(
        itertools.chain(*shards.values()), work=work, description=description, unit="shard"
    )
    return {name: success_rate(jobs, done) for name, jobs in shards.items()}


def trial_jobs(trial: Trial, needs: tuple[Job, ...] = ()) -> list[Job]:
    """The shards of a trial as jobs, after those that make its policy."""
    return [Job(run_trial, shard, needs) for shard in shards_of(trial)]


def success_rate(shards: Sequence[Job], done: Mapping[Job, Any]) -> dict[str, Any]:
    """The `summary` of one trial, from what its jobs gave."""
    return summary([Outcome(**outcome) for shard in shards for outcome in done[shard]])


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Success with its Wilson interval, control steps until success, and each start's outcome.

    ``outcomes`` has a 1 for each success and a 0 for each failure, in the order of the starts, so
    that policies can be compared start by start.
    """
    lengths = [outcome.steps for outcome in outcomes if outcome.success]
    success = success_of(len(lengths), len(outcomes))
    steps = float(np.mean(lengths)) if lengths else None
    each = "".join("01"[outcome.success] for outcome in outcomes)
    return {**vars(success), "steps": steps, "outcomes": each}


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
    policy = trial.policy.load(trial.robot)
    if trial.external is not None:
        return roll_out(policy, trial.external.simulation(), seeds)
    return roll_out(policy, judge_named(trial.judge, trial.robot, trial.task), seeds)


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
