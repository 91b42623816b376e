"""A saved policy, rolled out and shown."""

from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.sim.simulation import simulation
from lfr.transfer.actor import SkillActor
from lfr.view.rollout import roll_out_policy

from . import rrd
from .made_up import HORIZON, made_up_actor

SEED = 1_000_007


@pytest.fixture(scope="module")
def actor() -> SkillActor:
    return made_up_actor()


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
