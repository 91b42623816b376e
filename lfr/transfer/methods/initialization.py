"""What a run begins with: a policy to improve, the prior that it is held near, and what acts."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from torch import nn

from lfr.mapping.generator import Generator
from lfr.mapping.saved_generators import load_generator
from lfr.scenarios import Role, Transfer
from lfr.skills.library import RoleModels
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import load_prior, load_vae
from lfr.skills.vae import SkillVAE
from lfr.transfer.actor import SkillActor
from lfr.transfer.extended_policy import Phi, frozen_prior, initial_policy
from lfr.transfer.transfer_params import TransferParams


@dataclass(frozen=True)
class Initialization:
    """What a run begins with.

    Attributes:
        actor: policy, frozen prior and decoder. The policy is the one that will learn.
        normalizer: brings raw observations to unit scale for the critics.
        layout_names: the observation's dimensions, in order.
    """

    actor: SkillActor
    normalizer: nn.Module
    layout_names: tuple[str, ...]

    @property
    def latent_dim(self) -> int:
        """Z, the dimensions of a skill."""
        return self.actor.decoder.latent_dim


@dataclass(frozen=True)
class TrainedModels:
    """What was trained before RL for one transfer; loaded when asked for.

    Attributes:
        skills: the arms' skill models.
        mapping: folder of G and F.
    """

    transfer: Transfer
    skills: Mapping[Role, RoleModels]
    mapping: Path

    def source_prior(self) -> SkillPrior:
        """The source's prior of the new task, p_a of Eq. 8 and 9."""
        return load_prior(self.skills["source"].prior(self.transfer.task))

    def source_vae(self) -> SkillVAE:
        return load_vae(self.skills["source"].vae())

    def target_vae(self) -> SkillVAE:
        return load_vae(self.skills["target"].vae())

    def generator(self) -> Generator:
        """phi: G into the target's latent space."""
        return load_generator(self.mapping / "g")


def initialize_from(
    prior: nn.Module,
    phi: Phi,
    decoder: SkillVAE,
    params: TransferParams,
    reference: SkillPrior,
    pi: nn.Module | None = None,
) -> Initialization:
    """phi o pi with pi = ``prior`` to begin with (Eq. 7), held near phi o ``prior`` (Eq. 9).

    Args:
        prior: observations (B, D) to (mu, log_sigma), (B, Z) each.
        phi: into the latent space of ``decoder``.
        decoder: of the arm that acts.
        reference: the source's prior of the new task: whatever the method, the critics see the
            observation in its units.
        pi: begins instead of ``prior``.
    """
    actor = SkillActor(
        policy=initial_policy(
            pi or prior, phi, train_phi=params.train_phi, min_sigma=params.min_sigma
        ),
        prior=frozen_prior(prior, phi, params.min_sigma),
        decoder=copy.deepcopy(decoder).requires_grad_(False).eval(),
    )
    return Initialization(actor, reference.normalizer, reference.layout_names)


def new_pi(reference: SkillPrior, latent_dim: int, hidden: int, layers: int) -> SkillPrior:
    """A policy that has learned nothing; it sees the observation in the reference's units."""
    pi = SkillPrior(reference.layout_names, latent_dim, hidden, layers, reference.turned)
    pi.normalizer.load_state_dict(reference.normalizer.state_dict())
    return pi
