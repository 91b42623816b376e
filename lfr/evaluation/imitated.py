"""Trials of recurrent policies, and their training before them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, named_shards, run_trial, summaries
from lfr.imitation.artifacts import load_policy
from lfr.imitation.models import ImitationJob, fit_imitation
from lfr.imitation.policy import RecurrentPolicy
from lfr.jobs import run_jobs


@dataclass(frozen=True)
class ImitatedFiles:
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
        judged: trials of `ImitatedFiles`, by the seed of their policy and a name.

    Returns:
        What `lfr.imitation.models.fit_imitation` says of each policy, and the success of each
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
    return fit_imitation(part) if isinstance(part, ImitationJob) else run_trial(part)
