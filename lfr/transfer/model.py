"""A transferred policy on disk: one folder that holds everything needed to act."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.ablations.other_task import OTHER_TASK
from lfr.artifacts import as_json, save_model
from lfr.mapping.artifacts import GENERATOR
from lfr.models import ModelKind, read_model
from lfr.skills.artifacts import PRIOR, VAE
from lfr.transfer.actor import OneAction, SkillActor
from lfr.transfer.distribution import GAUSSIAN, distribution
from lfr.transfer.policy import IdentityMap, MappedPolicy, StandardNormal
from lfr.transfer.residual_prior import ResidualPriorPolicy

KIND = "transferred_policy"
# The networks that an actor consists of.
PARTS: dict[str, ModelKind[Any]] = {
    kind.network.__name__: kind
    for kind in (
        PRIOR,
        GENERATOR,
        VAE,
        OTHER_TASK,
        ModelKind("residual_prior_policy", ResidualPriorPolicy, OTHER_TASK.shape),
        ModelKind("identity_map", IdentityMap, ()),
        ModelKind("standard_normal", StandardNormal, ("latent_dim",)),
        ModelKind("one_action", OneAction, ("latent_dim",)),
    )
}


def save_policy(folder: Path, actor: SkillActor, about: dict[str, Any]) -> None:
    """Policy, frozen prior and decoder, with ``about`` (robot, task, method, parameters, ...)."""
    networks = _networks(actor)
    shapes = {}
    tensors = {}
    for name, network in networks.items():
        kind = type(network).__name__
        shapes[name] = {"class": kind, "shape": PARTS[kind].shape_of(network)}
        tensors |= {f"{name}.{key}": value for key, value in network.state_dict().items()}
    config = {"kind": KIND, "about": as_json(about), "networks": shapes}
    if actor.distribution != GAUSSIAN:
        config["distribution"] = actor.distribution.name
    if actor.policy.min_sigma > 0.0:
        config["min_sigma"] = actor.policy.min_sigma
    save_model(folder, config, tensors)


def load_policy(folder: Path) -> tuple[SkillActor, dict[str, Any]]:
    """The actor in a folder and what was saved about it.

    Raises:
        DataError: no transferred policy, or a damaged one.
    """
    config, tensors = read_model(folder, KIND)
    networks: dict[str, Any] = {}
    for name, entry in config["networks"].items():
        prefix = f"{name}."
        part = {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}
        network = PARTS[entry["class"]].build(entry["shape"], part, folder)
        networks[name] = network.requires_grad_(False)
    distributed = config.get("distribution", GAUSSIAN.name)
    return actor_of(networks, distributed, config.get("min_sigma", 0.0)), config["about"]


@dataclass(frozen=True)
class LearnedFiles:
    """The folder of a policy saved by `save_policy`."""

    policy: str

    def load(self) -> SkillActor:
        """Raises DataError where the folder holds no transferred policy, or a damaged one."""
        return load_policy(Path(self.policy))[0]


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
