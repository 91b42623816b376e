"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

from pathlib import Path

from lfr.evaluation.policies import SkillFiles
from lfr.evaluation.trials import Trial
from lfr.scenarios import Scenario, Transfer
from lfr.skills.models import prior_tasks, roles_of


def own_arm_trials(
    scenario: Scenario, transfer: Transfer, skills: Path, episodes: int
) -> dict[str, Trial]:
    """Every prior of a transfer on its own arm and task, by ``<role>/<task>``.

    Args:
        skills: folder of the transfer's skill models, by role.
    """
    trials = {}
    for role, robot in roles_of(transfer).items():
        for task in prior_tasks(scenario, robot, role):
            folder = skills / role
            files = SkillFiles(str(folder / f"prior-{task}"), str(folder / "vae"))
            trials[f"{role}/{task}"] = Trial(files, robot, task, episodes)
    return trials
