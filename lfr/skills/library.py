"""Where skill models lie, which of them transfers need, and who may work with which.

Models belong to a robot and the tasks that it was shown, so that transfers share them:
``<robot>/<tasks>/vae``, beside it a ``prior-<task>`` for its latent space and, where actions are
motions of the joints, the hand's ``jacobian``; ``<tasks>`` are the names in their order, joined by
"+". A transfer finds those of a role by what the leak rule lets the role see
(`lfr.scenarios.visible_tasks`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lfr.embodiments import may_share_actions
from lfr.errors import DataError
from lfr.scenarios import Role, Scenario, Transfer, check_visible, visible_tasks
from lfr.skills.saved_models import load_seen

MODELS = Path("models")  # of the pipeline


@dataclass(frozen=True)
class SkillFolder:
    """The folder of a skill VAE and of the priors for its latent space."""

    path: Path

    @property
    def vae(self) -> Path:
        return self.path / "vae"

    @property
    def jacobian(self) -> Path:
        return self.path / "jacobian"

    def prior(self, task: str) -> Path:
        return self.path / f"prior-{task}"


def tasks_name(tasks: Iterable[str]) -> str:
    """What the models are called that have seen these tasks."""
    return "+".join(sorted(tasks))


def skill_folder(root: Path, robot: str, tasks: Iterable[str]) -> SkillFolder:
    """Of a robot that was shown ``tasks``, below the folder of all skill models."""
    return SkillFolder(root / robot / tasks_name(tasks))


@dataclass(frozen=True)
class RoleModels:
    """The skill models that an arm works with in a role; a model is held to the leak rule when it
    is asked for.

    Attributes:
        scenario, robot, role: who asks.
        root: the folder of all skill models.
    """

    scenario: Scenario
    robot: str
    role: Role
    root: str

    @property
    def name(self) -> str:
        """``<robot>/<tasks>``, below the folder of all skill models."""
        return f"{self.robot}/{tasks_name(visible_tasks(self.scenario, self.robot, self.role))}"

    def vae(self) -> Path:
        """The folder of the skill VAE.

        Raises:
            DataError: it is missing, damaged or another robot's.
            LfrError: it has seen a task that is hidden from this role.
        """
        return self._checked(self._folder.vae)

    def jacobian(self) -> Path | None:
        """The folder of the hand's Jacobian, of an arm whose actions are joint motions; raises as
        `vae`.
        """
        folder = self._folder.jacobian
        return self._checked(folder) if folder.is_dir() else None

    def prior(self, task: str) -> Path:
        """The folder of a task's prior; raises as `vae`."""
        return self._checked(self._folder.prior(task))

    @property
    def _folder(self) -> SkillFolder:
        return SkillFolder(Path(self.root) / self.name)

    def _checked(self, model: Path) -> Path:
        seen = load_seen(model)
        if seen.robot != self.robot:
            raise DataError("the model is of another robot", file=model / "config.json",
                            found=seen.robot, expected=self.robot)  # fmt: skip
        check_visible(self.scenario, self.robot, self.role, seen.tasks)
        return model


def roles_of(transfer: Transfer) -> dict[Role, str]:
    """The arm in each role of a transfer; no oracle where nobody has shown it the new task."""
    roles: dict[Role, str] = {"source": transfer.source, "target": transfer.target}
    return {**roles, "oracle": transfer.target} if transfer.oracle else roles


def transfer_models(scenario: Scenario, transfer: Transfer, root: Path) -> dict[Role, RoleModels]:
    """The skill models of a transfer by role, below the folder of all skill models."""
    return {
        role: RoleModels(scenario, robot, role, str(root))
        for role, robot in roles_of(transfer).items()
    }


def skills_root(robot: str, arms: Collection[str], models: Path = MODELS) -> Path:
    """The folder that the pipeline leaves the skill models of a robot in.

    External arms' lie apart, so that what needs these asks for no demonstration of simulated ones.

    Args:
        arms: those that are external.
        models: the pipeline's folder of all models.
    """
    return models / ("external-skills" if robot in arms else "skills")


def pipeline_models(
    scenario: Scenario, transfer: Transfer, arms: Collection[str] = (), models: Path = MODELS
) -> dict[Role, RoleModels]:
    """The skill models of a transfer by role, where the pipeline leaves them (`skills_root`)."""
    return {
        role: RoleModels(scenario, robot, role, str(skills_root(robot, arms, models)))
        for role, robot in roles_of(transfer).items()
    }


def same_actions(skills: Mapping[Role, RoleModels]) -> bool:
    """Whether the actions of source and target are called alike, so that each can carry out the
    other's.

    Raises:
        DataError, LfrError: as `RoleModels.vae`.
    """
    source, target = (load_seen(skills[role].vae()) for role in ("source", "target"))
    return source.actions == target.actions and may_share_actions(source.robot, target.robot)


def prior_tasks(scenario: Scenario, robot: str, role: Role) -> tuple[str, ...]:
    """The tasks of which a role needs a prior: all visible ones, but the oracle only its new task.

    Its priors of the common tasks would not be used: the mapping is learned without the oracle.
    """
    visible = visible_tasks(scenario, robot, role)
    return visible[-1:] if role == "oracle" else visible


def needed_models(
    robot: str, transfers: Iterable[tuple[Scenario, Transfer]]
) -> dict[tuple[str, ...], tuple[str, ...]]:
    """The models of a robot that any of ``transfers`` needs in any role.

    Returns:
        The tasks that a VAE is to see -> those of them that are to get a prior, all in order.
    """
    needed: dict[tuple[str, ...], set[str]] = {}
    for scenario, transfer in transfers:
        for role, arm in roles_of(transfer).items():
            if arm == robot:
                seen = tuple(sorted(visible_tasks(scenario, robot, role)))
                needed.setdefault(seen, set()).update(prior_tasks(scenario, robot, role))
    return {seen: tuple(sorted(priors)) for seen, priors in sorted(needed.items())}
