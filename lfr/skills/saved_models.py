"""Skill models on disk: ``config.json``, which says what they saw, and their tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from lfr.columns import ActionSpace
from lfr.embodiments import embodiment, is_known, may_share_actions
from lfr.errors import DataError
from lfr.model_files import ModelKind, load_seen_as
from lfr.skills.hand_motion import HandJacobian
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE

VAE = ModelKind(
    "skill_vae",
    SkillVAE,
    ("horizon", "action_dim", "latent_dim", "hidden", "execute", "state_names", "turned",
     "whole_release"),
)  # fmt: skip
PRIOR = ModelKind(
    "skill_prior", SkillPrior, ("layout_names", "latent_dim", "hidden", "layers", "turned")
)
JACOBIAN = ModelKind("hand_jacobian", HandJacobian, ("joints", "hidden"))


@dataclass(frozen=True)
class Seen:
    """Which demonstrations a model has learned from: stored with it, and held to the leak rule.

    Attributes:
        robot: name of the embodiment whose actions it speaks of, or of the external arm.
        tasks: the tasks whose demonstrations reached it.
        datasets: dataset name -> SHA-256 of its rows.
        seed: of the training.
        actions: the names of the action's dimensions, and what -1 and 1 stand for; None where the
            model does not say.
    """

    robot: str
    tasks: tuple[str, ...]
    datasets: dict[str, str]
    seed: int
    actions: ActionSpace | None = None


def save_vae(folder: Path, vae: SkillVAE, seen: Seen) -> None:
    VAE.save(folder, vae, seen)


def load_vae(folder: Path) -> SkillVAE:
    """The skill VAE in a folder, ready to encode and decode.

    Raises:
        DataError: the folder holds no skill VAE, or a damaged one.
    """
    return VAE.load(folder)


def save_prior(folder: Path, prior: SkillPrior, seen: Seen) -> None:
    PRIOR.save(folder, prior, seen)


def load_prior(folder: Path, layout_names: Sequence[str] | None = None) -> SkillPrior:
    """The skill prior in a folder.

    Args:
        layout_names: the observation that it will be given; None takes the model's word.

    Raises:
        DataError: no skill prior, a damaged one, or one trained on another state layout.
    """
    prior = PRIOR.load(folder)
    if layout_names is not None:
        check_layout(folder, prior.layout_names, layout_names)
    return prior


def save_jacobian(folder: Path, jacobian: HandJacobian, seen: Seen) -> None:
    JACOBIAN.save(folder, jacobian, seen)


def load_jacobian(folder: Path) -> HandJacobian:
    """The hand's Jacobian in a folder; raises as `load_vae`."""
    return JACOBIAN.load(folder)


def load_seen(folder: Path) -> Seen:
    """What the model in a folder has learned from."""
    return load_seen_as(Seen, folder)


def check_layout(folder: Path, found: Sequence[str], expected: Sequence[str]) -> None:
    """Hold a model to the observation that it will be given.

    Raises:
        DataError: the model was trained on another state layout; names the first difference.
    """
    _compare(
        "the model was trained on another state layout; train it on this task's dataset",
        folder, found, expected,
    )  # fmt: skip


def check_actions(folder: Path, robot: str) -> None:
    """Hold a model to the embodiment that is to carry out its actions.

    It may be another than the model's own where their actions are the same things: so the chain's
    link `identity` and AP ask for it.

    Raises:
        DataError: the model's actions are another controller's, or move other joints; names the
            first difference.
        UnknownNameError: no such embodiment.
    """
    seen = load_seen(folder)
    if seen.robot == robot or not is_known(robot):
        return  # its own; or of an arm that is known by its datasets, where whoever asks compares
    found = seen.actions.names if seen.actions else embodiment(seen.robot).action.names
    expected = embodiment(robot).action.names
    message = f"{robot} cannot carry out the actions of {seen.robot}"
    _compare(message, folder, found, expected)
    if not may_share_actions(seen.robot, robot):
        raise DataError(message, file=folder / "config.json", found=seen.robot, expected=robot)


def _compare(message: str, folder: Path, found: Sequence[str], expected: Sequence[str]) -> None:
    for place, (was, wanted) in enumerate(zip_longest(found, expected)):
        if was != wanted:
            raise DataError(
                message,
                file=folder / "config.json",
                column=f"dimension {place}",
                found=was,
                expected=wanted,
            )
