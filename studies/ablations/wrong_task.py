"""The source's prior of another task in the new task's place: does the prior matter at all?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.scenarios import Transfer
from lfr.skills.library import RoleModels
from lfr.skills.saved_models import load_prior, load_seen
from lfr.tasks import task as task_named
from studies.ablations.other_task import asked_about, save_other_task


@dataclass(frozen=True)
class WrongTaskJob:
    """The source's prior of the first common task, asked about the new one; nothing is trained.

    Attributes:
        skills: the source's.
        folder: where ``prior`` is saved.
    """

    transfer: Transfer
    skills: RoleModels
    folder: str


def make_wrong_task(job: WrongTaskJob) -> dict[str, Any]:
    """Save the prior of the first common task so that it answers the new task's observations."""
    wrong, new = task_named(job.transfer.common[0]), task_named(job.transfer.task)
    folder = job.skills.prior(wrong.name)
    inner = load_prior(folder, wrong.observation.names)
    names = new.observation.names
    prior = asked_about(inner, wrong.manipulated, names, new.manipulated)
    save_other_task(Path(job.folder) / "prior", prior, load_seen(folder))
    lacking = [name for name, c in zip(prior.inner_names, prior.columns, strict=True) if c < 0]
    return {"task": wrong.name, "lacking": lacking}
