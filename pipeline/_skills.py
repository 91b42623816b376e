"""Where the stage skills leaves the models of each robot."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from lfr.scenarios import Role, Scenario, Transfer
from lfr.skills.library import RoleModels, transfer_models

# Apart, so that what needs the second asks for no demonstration of a simulated arm.
SKILLS, EXTERNAL_SKILLS = Path("models/skills"), Path("models/external-skills")


def skills_root(robot: str, arms: Collection[str]) -> Path:
    """The folder that the models of a robot lie in; ``arms`` are those that are external."""
    return EXTERNAL_SKILLS if robot in arms else SKILLS


def skills_of(
    scenario: Scenario, transfer: Transfer, arms: Collection[str] = ()
) -> dict[Role, RoleModels]:
    """The skill models of a transfer, by role."""
    return {
        role: replace(models, root=str(skills_root(models.robot, arms)))
        for role, models in transfer_models(scenario, transfer, SKILLS).items()
    }
