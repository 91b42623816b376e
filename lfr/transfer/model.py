"""A transferred policy on disk: one folder that holds everything needed to act."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from torch import nn

from lfr.artifacts import load_model, plain, save_model
from lfr.errors import DataError
from lfr.mapping.generator import Generator
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.actor import SkillActor
from lfr.transfer.policy import IdentityMap, MappedPolicy

KIND = "transferred_policy"

# What each network is built from; its attributes carry the constructor's names.
SHAPES: dict[str, tuple[type[nn.Module], tuple[str, ...]]] = {
    "SkillPrior": (SkillPrior, ("layout_names", "latent_dim", "hidden", "layers")),
    "Generator": (Generator, ("latent_dim", "hidden", "layers")),
    "IdentityMap": (IdentityMap, ()),
    "SkillVAE": (SkillVAE, ("horizon", "action_dim", "latent_dim", "hidden", "execute")),
}


def save_policy(folder: Path, actor: SkillActor, about: dict[str, Any]) -> None:
    """Policy, frozen prior and decoder, with ``about`` (robot, task, method, parameters, ...)."""
    networks = _networks(actor)
    shapes = {}
    tensors = {}
    for name, network in networks.items():
        kind = type(network).__name__
        _, attributes = SHAPES[kind]
        shape = {attribute: plain(getattr(network, attribute)) for attribute in attributes}
        shapes[name] = {"class": kind, "shape": shape}
        tensors |= {f"{name}.{key}": value for key, value in network.state_dict().items()}
    save_model(folder, {"kind": KIND, "about": plain(about), "networks": shapes}, tensors)


def load_policy(folder: Path) -> tuple[SkillActor, dict[str, Any]]:
    """The actor in a folder and what was saved about it.

    Raises:
        DataError: no transferred policy, or a damaged one.
    """
    config, tensors = load_model(folder)
    if config.get("kind") != KIND:
        raise DataError(
            "another kind of model",
            file=folder / "config.json", found=config.get("kind"), expected=KIND,
        )  # fmt: skip
    networks: dict[str, Any] = {}
    for name, entry in config["networks"].items():
        kind, _ = SHAPES[entry["class"]]
        network = kind(**entry["shape"])
        prefix = f"{name}."
        part = {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}
        try:
            network.load_state_dict(part)
        except RuntimeError as error:
            raise DataError(
                "the tensors do not fit the configuration",
                file=folder / "model.safetensors", found=str(error).splitlines()[-1].strip(),
            ) from None  # fmt: skip
        networks[name] = network.requires_grad_(False).eval()
    actor = SkillActor(
        policy=MappedPolicy(networks["pi"], networks["phi"]),
        prior=MappedPolicy(networks["p_a"], networks["phi_prior"]),
        decoder=networks["decoder"],
    )
    return actor, config["about"]


def _networks(actor: SkillActor) -> dict[str, nn.Module]:
    return {
        "pi": actor.policy.pi,
        "phi": actor.policy.phi,
        "p_a": actor.prior.pi,
        "phi_prior": actor.prior.phi,
        "decoder": actor.decoder,
    }
