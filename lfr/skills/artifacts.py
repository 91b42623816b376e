"""Skill models on disk: ``config.json``, which says what they saw, and their tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torch import nn

from lfr.artifacts import load_model, plain, save_model
from lfr.errors import DataError
from lfr.params import from_mapping
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE


@dataclass(frozen=True)
class Seen:
    """Which demonstrations a model has learned from: stored with it, and held to the leak rule.

    Attributes:
        scenario, robot, role: who the model is (`lfr.scenarios.visible_tasks`).
        tasks: the tasks whose demonstrations reached it.
        datasets: dataset name -> SHA-256 of its rows.
        seed: of the training.
    """

    scenario: str
    robot: str
    role: str
    tasks: tuple[str, ...]
    datasets: dict[str, str]
    seed: int


def save_vae(folder: Path, vae: SkillVAE, seen: Seen) -> None:
    shape = ("horizon", "action_dim", "latent_dim", "hidden", "execute")
    save_kind(folder, "skill_vae", {name: getattr(vae, name) for name in shape}, vae, seen)


def load_vae(folder: Path) -> SkillVAE:
    """The skill VAE in a folder, ready to encode and decode.

    Raises:
        DataError: the folder holds no skill VAE, or a damaged one.
    """
    shape, _, tensors = load_kind(folder, "skill_vae")
    return restored(SkillVAE(**shape), tensors, folder)


def save_prior(folder: Path, prior: SkillPrior, seen: Seen) -> None:
    shape = ("layout_names", "latent_dim", "hidden", "layers")
    save_kind(folder, "skill_prior", {name: getattr(prior, name) for name in shape}, prior, seen)


def load_prior(folder: Path, layout_names: Sequence[str] | None = None) -> SkillPrior:
    """The skill prior in a folder.

    Args:
        layout_names: the observation that it will be given; None takes the model's word.

    Raises:
        DataError: no skill prior, a damaged one, or one trained on another state layout.
    """
    shape, _, tensors = load_kind(folder, "skill_prior")
    if layout_names is not None:
        check_layout(folder, shape["layout_names"], layout_names)
    return restored(SkillPrior(**shape), tensors, folder)


def load_seen(folder: Path) -> Seen:
    """What the model in a folder has learned from."""
    _, seen, _ = load_kind(folder, None)
    return from_mapping(Seen, seen, str(folder / "config.json"))


def check_layout(folder: Path, found: Sequence[str], expected: Sequence[str]) -> None:
    """Hold a model to the observation that it will be given.

    Raises:
        DataError: the model was trained on another state layout; names the first difference.
    """
    if list(found) == list(expected):
        return
    pairs = zip([*found, None], [*expected, None], strict=False)
    place, (was, wanted) = next((i, pair) for i, pair in enumerate(pairs) if pair[0] != pair[1])
    raise DataError(
        "the model was trained on another state layout; train it on this task's dataset",
        file=folder / "config.json",
        column=f"dimension {place}",
        found=was,
        expected=wanted,
    )


def save_kind(
    folder: Path, kind: str, shape: dict[str, Any], model: nn.Module, seen: object
) -> None:
    """A model with what it takes to build it again, and what it has seen (a dataclass)."""
    config = {"kind": kind, "model": plain(shape), "seen": plain(seen)}
    save_model(folder, config, model.state_dict())


def load_kind(
    folder: Path, kind: str | None
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """A model's shape, what it has seen, and its tensors; ``kind`` None takes any.

    Raises:
        DataError: the folder holds no model of this kind, or a damaged one.
    """
    config, tensors = load_model(folder)
    if kind is not None and config.get("kind") != kind:
        raise DataError(
            "another kind of model",
            file=folder / "config.json",
            found=config.get("kind"),
            expected=kind,
        )
    return config["model"], config["seen"], tensors


def restored[Model: nn.Module](model: Model, tensors: dict[str, Any], folder: Path) -> Model:
    """The model with these tensors, ready to be used.

    Raises:
        DataError: they do not fit it.
    """
    try:
        model.load_state_dict(tensors)
    except RuntimeError as error:
        raise DataError(
            "the tensors do not fit the configuration",
            file=folder / "model.safetensors",
            found=str(error).splitlines()[-1].strip(),
        ) from None
    return model.eval()
