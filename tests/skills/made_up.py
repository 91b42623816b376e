"""Skill models of nobody, where those of a role lie."""

from __future__ import annotations

from pathlib import Path

from lfr.columns import ActionSpace
from lfr.embodiments import embodiment, is_known
from lfr.scenarios import visible_tasks
from lfr.skills.library import RoleModels, skill_folder
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen, save_prior, save_vae
from lfr.skills.vae import SkillVAE


def save_models(role: RoleModels, vae: SkillVAE, priors: dict[str, SkillPrior]) -> None:
    """A VAE that has seen what the role may see, and priors by task."""
    tasks = visible_tasks(role.scenario, role.robot, role.role)
    folder, actions = skill_folder(Path(role.root), role.robot, tasks), actions_of(role.robot)
    save_vae(folder.vae, vae, Seen(role.robot, tasks, {}, 0, actions))
    for task, prior in priors.items():
        save_prior(folder.prior(task), prior, Seen(role.robot, (task,), {}, 0, actions))


def actions_of(robot: str) -> ActionSpace | None:
    """What is recorded of an embodiment's actions; None of an arm that nobody knows."""
    if not is_known(robot):
        return None
    names = embodiment(robot).action.names
    return ActionSpace(names, (-1.0,) * len(names), (1.0,) * len(names))
