"""BC+RNN of a transfer, as a job: the source arm's demonstrations of the new task, cloned."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import file_hash, fingerprint
from lfr.data.checks import check_dataset
from lfr.data.episode import FPS, JOINT_POSITION, features_of
from lfr.data.windows import DemonstrationSet, read_dataset
from lfr.embodiments import embodiment
from lfr.scenarios import Scenario, check_visible
from lfr.skills.saved_models import Seen
from lfr.tasks import task as task_named
from studies.imitation.imitation_params import ImitationParams
from studies.imitation.likelihood import log_likelihood, train_bc
from studies.imitation.saved_policies import save_policy


@dataclass(frozen=True)
class ImitationJob:
    """A policy to clone from the demonstrations of one task by the arm that teaches it.

    Attributes:
        robot: the arm that demonstrates, the transfer's source.
        held_out: share of the episodes kept for the report; with ``seed`` it says which, the same
            as for skill models (`lfr.skills.demonstrations.read_demonstrations`).
        folder: where the policy goes.
        datasets: folder of the datasets.
    """

    scenario: Scenario
    robot: str
    task: str
    params: ImitationParams
    held_out: float
    seed: int
    folder: str
    datasets: str

    @property
    def dataset(self) -> Path:
        return Path(self.datasets) / f"{self.robot}-{self.task}"


def fit_imitation(job: ImitationJob) -> dict[str, Any]:
    """Train and save a policy; its updates, its seconds, and what it makes of held-out episodes.

    Raises:
        LfrError: the task is hidden from the arm in the role "source"; nothing has been read then.
        DataError: the dataset is missing or not what training needs.
    """
    check_visible(job.scenario, job.robot, "source", (job.task,))
    demonstrations = read_recorded(job.dataset, job.robot, job.task)
    training, held_out = demonstrations.split(job.held_out, job.seed)
    seed = imitation_seed(job)
    began = time.perf_counter()
    policy = train_bc(training, job.params, seed)
    seconds = time.perf_counter() - began
    digests = {job.dataset.name: file_hash(job.dataset / "data")}
    space = demonstrations.action_space
    seen = Seen(job.robot, (job.task,), digests, seed, space)
    save_policy(Path(job.folder), policy, seen)
    return {
        "updates": job.params.updates,
        "seconds": round(seconds, 1),
        "log_likelihood_training": log_likelihood(policy, training),
        "log_likelihood_held_out": log_likelihood(policy, held_out),
        "datasets": digests,
    }


def imitation_seed(job: ImitationJob) -> int:
    """A seed of its own for each policy: its weights and the order of its batches."""
    name = (job.scenario.name, job.robot, "bc_rnn", job.task, job.seed)
    return int(fingerprint(*name), 16) % 2**31


def read_recorded(path: Path, robot: str, task: str) -> DemonstrationSet:
    """One of this project's own datasets, checked; `fit_imitation` holds the leak rule.

    Raises:
        DataError: it is missing or not what training needs.
    """
    expected = features_of(embodiment(robot), task_named(task))
    # Joint names differ by robot, and nothing here learns from them.
    needed = {key: feature for key, feature in expected.items() if key != JOINT_POSITION}
    check_dataset(path, features=needed, fps=FPS, robot=robot, task=task)
    return read_dataset(path)
