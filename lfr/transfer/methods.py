"""The methods that can be trained on the target arm: what each one starts from.

A method is a factory from the artifacts at hand to the three things that a run needs. A new one is
a small file beside this with such a factory, and a row in ``METHODS``.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass

from torch import nn

from lfr.errors import UnknownNameError
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.actor import SkillActor
from lfr.transfer.params import TransferParams
from lfr.transfer.policy import frozen_prior, initial_policy


@dataclass(frozen=True)
class Artifacts:
    """What was trained before RL.

    Attributes:
        source_prior: the source arm's prior of the new task, p_a of Eq. 8 and 9.
        generator: phi into the target's latent space, (mu, log_sigma) to (mu, log_sigma).
        target_vae: the target arm's skill VAE.
    """

    source_prior: SkillPrior
    generator: nn.Module
    target_vae: SkillVAE


@dataclass(frozen=True)
class Start:
    """Where a run starts.

    Attributes:
        actor: policy, frozen prior and decoder. The policy is the one that will learn.
        normalizer: brings raw observations to unit scale for the critics.
        layout_names: the observation's dimensions, in order.
        latent_dim: Z.
    """

    actor: SkillActor
    normalizer: nn.Module
    layout_names: tuple[str, ...]
    latent_dim: int


Method = Callable[[Artifacts, TransferParams], Start]


def lfr(artifacts: Artifacts, params: TransferParams) -> Start:
    """Learn from Robot: pi' = phi o pi from the source's prior (Eq. 7), near phi(p_a) (Eq. 9)."""
    prior, phi = artifacts.source_prior, artifacts.generator
    decoder = copy.deepcopy(artifacts.target_vae).requires_grad_(False).eval()
    actor = SkillActor(
        policy=initial_policy(prior, phi, train_phi=params.train_phi),
        prior=frozen_prior(prior, phi),
        decoder=decoder,
    )
    return Start(actor, prior.normalizer, prior.layout_names, decoder.latent_dim)


METHODS: dict[str, Method] = {"lfr": lfr}


def method(name: str) -> Method:
    """The method called ``name``.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in METHODS:
        raise UnknownNameError("method", name, METHODS)
    return METHODS[name]
