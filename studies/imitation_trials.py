"""Trials of recurrent policies, which begin every episode anew, and their training before them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from lfr.evaluation import trials
from lfr.evaluation.rollouts import Judge, Outcome, roll_out
from lfr.evaluation.trials import Trial, named_shards, summaries
from lfr.jobs import run_jobs
from lfr.seeds import episode_seed
from studies.imitation.cloning import ImitationJob, fit_imitation
from studies.imitation.recurrent_policy import RecurrentPolicy
from studies.imitation.saved_policies import load_policy


class EpisodicPolicy(Protocol):
    """A policy that remembers within an episode and is told when one begins."""

    def reset(self, seed: int = 0) -> None: ...
    def act(self, observation: np.ndarray) -> np.ndarray: ...


@dataclass(frozen=True)
class RecurrentPolicyFiles:
    """The folder of a recurrent policy; it names the policy in a job."""

    policy: str

    def load(self) -> RecurrentPolicy:
        """Raises DataError where the folder holds no recurrent policy, or a damaged one."""
        return RecurrentPolicy(load_policy(Path(self.policy)))


def train_and_judge(
    policies: Mapping[int, ImitationJob],
    judged: Mapping[tuple[int, str], Trial],
    work: Path,
    description: str,
) -> tuple[dict[int, dict[str, Any]], dict[tuple[int, str], dict[str, Any]]]:
    """Train policies, and judge each as soon as it is there.

    Args:
        policies: by seed.
        judged: trials of `RecurrentPolicyFiles`, by the seed of their policy and a name.

    Returns:
        What `studies.imitation.cloning.fit_imitation` says of each policy, and the success of each
        trial, as `lfr.evaluation.trials.success_rates` gives it.
    """
    places = {seed: place for place, seed in enumerate(policies)}
    names = list(judged)
    shards = named_shards({str(place): judged[name] for place, name in enumerate(names)})
    owners = [names[int(place)] for place, _ in shards]
    after = {len(places) + i: places[seed] for i, (seed, _) in enumerate(owners)}
    jobs = [*policies.values(), *(shard for _, shard in shards)]
    done = run_jobs(run_part, jobs, after=after, work=work, description=description, unit="part")
    fitted = dict(zip(policies, done[: len(places)], strict=True))
    return fitted, summaries(owners, done[len(places) :])


def run_part(part: ImitationJob | Trial) -> Any:
    """A policy to train, or a shard of a trial of one."""
    return fit_imitation(part) if isinstance(part, ImitationJob) else run_recurrent(part)


def run_recurrent(trial: Trial) -> list[Outcome]:
    """`lfr.evaluation.trials.run_trial` for a policy that is to be told when an episode begins."""
    policy = trial.policy.load()
    assert isinstance(policy, RecurrentPolicy)
    simulation = trials.judge_named(trial.judge, trial.robot, trial.task)
    numbers = range(trial.first, trial.first + trial.episodes)
    return roll_out_anew(policy, simulation, [episode_seed("held-out", i) for i in numbers])


def roll_out_anew(policy: EpisodicPolicy, simulation: Judge, seeds: list[int]) -> list[Outcome]:
    """One episode per seed, the policy reset with that seed before each."""
    outcomes: list[Outcome] = []
    for seed in seeds:
        policy.reset(seed)
        outcomes += roll_out(policy, simulation, [seed])
    return outcomes
