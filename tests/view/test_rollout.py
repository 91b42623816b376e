"""A saved policy, rolled out and shown."""

from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.sim.simulation import simulation
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.actor import SkillActor
from lfr.transfer.policy import IdentityMap, frozen_prior, initial_policy
from lfr.view.rollout import roll_out_policy

from . import rrd

HORIZON, LATENT, SEED = 10, 4, 1_000_007


@pytest.fixture(scope="module")
def actor() -> SkillActor:
    torch.manual_seed(0)
    names = simulation("panda", "lift").layout.names
    prior = SkillPrior(names, latent_dim=LATENT, hidden=16, layers=2)
    decoder = SkillVAE(horizon=HORIZON, action_dim=7, latent_dim=LATENT, hidden=16)
    policy = initial_policy(prior, IdentityMap(), train_phi=True)
    with torch.no_grad():  # as if it had learned something
        for parameter in policy.parameters():
            parameter.add_(0.05)
    return SkillActor(policy.eval(), frozen_prior(prior, IdentityMap()), decoder.eval())


def test_the_episode_is_what_the_simulation_does(actor: SkillActor) -> None:
    engine = simulation("panda", "lift")
    before = torch.get_rng_state()
    episode, trace = roll_out_policy(actor, engine, SEED)
    assert torch.equal(torch.get_rng_state(), before)
    assert len(episode) == engine.horizon
    np.testing.assert_array_equal(trace.skill_start, np.arange(0, engine.horizon, HORIZON))

    observation = engine.reset(SEED)
    actions = actor.act(observation)
    np.testing.assert_allclose(episode.features["action"][:HORIZON], actions, atol=1e-6)
    after = engine.step(actions).observations[-1]
    np.testing.assert_allclose(
        episode.features["observation.state"][HORIZON], after[:11], atol=1e-6
    )
    np.testing.assert_array_equal(trace.z, trace.policy_mu)  # the mean acts
    np.testing.assert_allclose(trace.prior_mu, trace.mapped_mu)  # phi is the identity here
    assert (trace.divergence > 0).all()


def test_a_policys_folder_is_viewed(actor: SkillActor, tmp_path: Path) -> None:
    from lfr.cli import main
    from lfr.transfer.model import save_policy

    folder = tmp_path / "s1-panda-lift-lfr" / "seed-0"
    save_policy(folder, actor, {"robot": "panda", "task": "lift"})
    out = tmp_path / "policy.rrd"
    assert main(["view", str(folder), "--seed", str(SEED), "--save", str(out)]) == 0
    entities = rrd.read(out)
    assert "/latent/target/policy/spread" in entities
    assert "/world/cube_main" in entities
