"""A policy that has learned nothing much."""

from __future__ import annotations

import torch

from lfr.sim.simulation import simulation
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.actor import SkillActor
from lfr.transfer.extended_policy import IdentityMap, frozen_prior, initial_policy

HORIZON, LATENT = 10, 4


def made_up_actor() -> SkillActor:
    """Panda's, on Lift; the same one each time."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        names = simulation("panda", "lift").layout.names
        prior = SkillPrior(names, latent_dim=LATENT, hidden=16, layers=2)
        decoder = SkillVAE(horizon=HORIZON, action_dim=7, latent_dim=LATENT, hidden=16)
    policy = initial_policy(prior, IdentityMap(), train_phi=True)
    with torch.no_grad():  # as if it had learned something
        for parameter in policy.parameters():
            parameter.add_(0.05)
    return SkillActor(policy.eval(), frozen_prior(prior, IdentityMap()), decoder.eval())
