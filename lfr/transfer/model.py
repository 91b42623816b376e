"""A transferred policy on disk: one folder that holds everything needed to act."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import as_json, save_model
from lfr.errors import DataError
from lfr.model_files import read_model
from lfr.transfer.actor import SkillActor
from lfr.transfer.distribution import GAUSSIAN, distribution
from lfr.transfer.extended_policy import MappedPolicy
from lfr.transfer.network_kinds import network_kind

if TYPE_CHECKING:
    from torch import Tensor

KIND = "transferred_policy"


def save_policy(folder: Path, actor: SkillActor, about: dict[str, Any]) -> None:
    """Policy, frozen prior and decoder, with ``about`` (robot, task, method, parameters, ...).

    Raises:
        DataError: a network of a kind that is not known (`lfr.transfer.network_kinds`).
    """
    shapes, tensors = described(actor, folder / "config.json")
    config = {"kind": KIND, "about": as_json(about), "networks": shapes}
    if actor.distribution != GAUSSIAN:
        config["distribution"] = actor.distribution.name
    if actor.policy.min_sigma > 0.0:
        config["min_sigma"] = actor.policy.min_sigma
    save_model(folder, config, tensors)


def described(actor: SkillActor, file: Path) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """Its networks' classes and the arguments of their constructors by name, and all tensors.

    Args:
        file: where they will stand, for messages.

    Raises:
        DataError: a network of a kind that is not known.
    """
    shapes: dict[str, Any] = {}
    tensors: dict[str, Tensor] = {}
    for name, network in _networks(actor).items():
        kind = type(network).__name__
        shapes[name] = {"class": kind, "shape": network_kind(kind, file).shape_of(network)}
        tensors |= {f"{name}.{key}": value for key, value in network.state_dict().items()}
    return shapes, tensors


def load_policy(folder: Path) -> tuple[SkillActor, dict[str, Any]]:
    """The actor in a folder and what was saved about it.

    Raises:
        DataError: no transferred policy, a damaged one, or one with a network of a kind that is
            not known (`lfr.transfer.network_kinds`).
    """
    config, tensors = read_model(folder, KIND)
    networks: dict[str, Any] = {}
    for name, entry in config["networks"].items():
        prefix = f"{name}."
        part = {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}
        kind = network_kind(entry["class"], folder / "config.json")
        networks[name] = kind.build(entry["shape"], part, folder).requires_grad_(False)
    distributed = config.get("distribution", GAUSSIAN.name)
    return actor_of(networks, distributed, config.get("min_sigma", 0.0)), config["about"]


@dataclass(frozen=True)
class LearnedFiles:
    """The folder of a policy saved by `save_policy`."""

    policy: str

    def load(self, robot: str) -> SkillActor:
        """Raises DataError where the folder holds no policy of this robot, or a damaged one."""
        folder = Path(self.policy)
        actor, about = load_policy(folder)
        if about.get("robot") != robot:
            raise DataError("the policy is of another robot", file=folder / "config.json",
                            found=about.get("robot"), expected=robot)  # fmt: skip
        return actor


def actor_of(
    networks: dict[str, Any], distributed: str = GAUSSIAN.name, min_sigma: float = 0.0
) -> SkillActor:
    """The actor that consists of these networks, by the names that `save_policy` gives them."""
    return SkillActor(
        policy=MappedPolicy(networks["pi"], networks["phi"], min_sigma),
        prior=MappedPolicy(networks["p_a"], networks["phi_prior"], min_sigma),
        decoder=networks["decoder"],
        distribution=distribution(distributed),
    )


def _networks(actor: SkillActor) -> dict[str, Any]:
    return {
        "pi": actor.policy.pi,
        "phi": actor.policy.phi,
        "p_a": actor.prior.pi,
        "phi_prior": actor.prior.phi,
        "decoder": actor.decoder,
    }
