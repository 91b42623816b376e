"""Trials of recurrent policies, and their training before them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, run_trial, shards_of, success_rate
from lfr.jobs import Job, run_jobs
from lfr.skills.saved_models import check_actions
from studies.imitation.cloning import ImitationJob, fit_imitation
from studies.imitation.recurrent_policy import RecurrentPolicy
from studies.imitation.saved_policies import load_policy


@dataclass(frozen=True)
class RecurrentPolicyFiles:
    """The folder of a recurrent policy; it names the policy in a job."""

    policy: str

    def load(self, robot: str) -> RecurrentPolicy:
        """Raises DataError where the folder holds no such policy, a damaged or another robot's."""
        check_actions(Path(self.policy), robot)
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
    training = {seed: Job(fit_imitation, spec) for seed, spec in policies.items()}
    shards = {
        key: [Job(run_trial, shard, (training[key[0]],)) for shard in shards_of(trial)]
        for key, trial in judged.items()
    }
    jobs = [*training.values(), *itertools.chain(*shards.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    fitted = {seed: done[job] for seed, job in training.items()}
    return fitted, {key: success_rate(trial, done) for key, trial in shards.items()}
