"""Where each method starts, from models in folders; and SAC, which starts from nothing."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.ablations.other_task import OtherTaskPrior, save_other_task
from lfr.errors import DataError
from lfr.mapping.artifacts import MappingSeen, save_generator
from lfr.mapping.generator import Generator
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.artifacts import Seen
from lfr.skills.library import transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.distribution import SQUASHED
from lfr.transfer.loop import TransferLoop
from lfr.transfer.methods import start_of
from lfr.transfer.methods.start import TrainedModels
from lfr.transfer.model import load_policy, save_policy
from tests.skills.made_up import save_models

from .point import NAMES, PointSimulation

SCENARIO = Scenario("s", ("lift",), {"a": "other", "b": "new"})
_, TRANSFER = transfers_of(SCENARIO)  # from a to b


@pytest.fixture
def models(tmp_path: Path) -> TrainedModels:
    torch.manual_seed(1)
    skills, mapping = transfer_models(SCENARIO, TRANSFER, tmp_path / "skills"), tmp_path / "mapping"
    vaes = SkillVAE(3, 2, 4, 8), SkillVAE(3, 2, 4, 8)
    prior = SkillPrior(NAMES, latent_dim=4, hidden=16, layers=2)
    prior.normalizer.mean.fill_(0.5)
    save_models(skills["source"], vaes[0], {"new": prior})
    save_models(skills["target"], vaes[1], {})
    mapped = MappingSeen("s-b-new", "a", "b", ("a/lift+new", "b/lift"), ("lift",), {}, 0)
    save_generator(mapping / "g", Generator(4, 16, 3), mapped)
    only = Generator(4, 16, 3)
    save_generator(tmp_path / "variants" / "only_lift" / "g", only, mapped)
    return TrainedModels(TRANSFER, skills, mapping, tmp_path / "variants")


def test_methods_differ_in_phi_and_decoder_alone(models, params):
    observation = torch.randn(5, 3)
    prior, g = models.source_prior(), models.generator()
    decoders = {"lfr": "target", "ap": "source", "no_generator": "target", "only_lift": "target"}
    starts = {name: start_of(name, models, params, 0) for name in decoders}
    for name, start in starts.items():
        vae = models.target_vae() if decoders[name] == "target" else models.source_vae()
        z = torch.randn(2, 4)
        torch.testing.assert_close(start.actor.decoder.carry_out(z), vae.carry_out(z))
        # before any learning, the policy is the prior that it is held near
        mine, held = start.actor.policy(observation), start.actor.prior(observation)
        torch.testing.assert_close(mine, held)
    torch.testing.assert_close(starts["lfr"].actor.prior(observation), g(*prior(observation)))
    for name in ("ap", "no_generator"):
        torch.testing.assert_close(starts[name].actor.prior(observation), prior(observation))
    only = starts["only_lift"].actor.prior(observation)[0]
    assert not torch.allclose(only, starts["lfr"].actor.prior(observation)[0])


def test_critics_see_the_same_units_whatever_the_method(models, params):
    observation = torch.randn(5, 3)
    expected = models.source_prior().normalizer(observation)
    for name in ("lfr", "ap", "no_generator", "sac", "spirl_no_prior"):
        start = start_of(name, models, params, 0)
        torch.testing.assert_close(start.normalizer(observation), expected)
        assert start.layout_names == NAMES


def test_a_new_policy_depends_on_the_seed_alone(models, params):
    observation = torch.randn(5, 3)
    for name in ("sac", "spirl_no_prior"):
        one, again, other = (start_of(name, models, params, seed) for seed in (3, 3, 4))
        found = [start.actor.policy(observation)[0] for start in (one, again, other)]
        assert torch.equal(found[0], found[1])
        assert not torch.equal(found[0], found[2])
        assert not one.actor.prior(observation)[0].any()


def test_sac_acts_step_by_step_within_bounds(models, params, tmp_path):
    actor = start_of("sac", models, params, 0).actor
    assert actor.distribution == SQUASHED
    observations = 50.0 * np.random.default_rng(0).standard_normal((6, 3))
    assert actor.act(observations).shape == (6, 1, 2)
    noisy = actor.choose(torch.randn(500, 3), torch.Generator().manual_seed(0)).z
    assert noisy.abs().max() <= 1.0
    assert noisy.std() > 0.3  # a new policy tries everything
    save_policy(tmp_path / "policy", actor, {})
    again, _ = load_policy(tmp_path / "policy")
    assert again.distribution == SQUASHED
    np.testing.assert_allclose(again.act(observations), actor.act(observations))


def test_sac_learns_a_trivial_task(models, params):
    learning = dataclasses.replace(
        params, steps=1500, warm_up=200, replay=2000, updates_per_skill=1.0, batch=64,
        policy_lr=3e-3, critic_lr=3e-3, policy_every=1, tau=0.05, gamma=0.9, reward="dense",
        dense_scale=1.0, target_divergence=2 * (1 + math.log(2)), evaluation_episodes=20,
        evaluate_every=500, critic_hidden=(32, 32),
    )  # fmt: skip
    start = start_of("sac", models, learning, 0)
    simulations = [PointSimulation() for _ in range(learning.simulations)]
    curve = TransferLoop(start, simulations, learning, 0).run()
    assert curve[-1].success >= 0.9


def test_who_begins_with_another_tasks_prior_sees_everything(models, params, tmp_path):
    """The prior that it is held near does not; SPiRL's policy may still learn to seek a goal."""
    torch.manual_seed(5)
    inner = SkillPrior(("x_pos", "goal_to_x"), latent_dim=4, hidden=16, layers=2)
    prior = OtherTaskPrior(NAMES, inner.layout_names, (0, 2), 4, 16, 2)
    prior.inner.load_state_dict(inner.state_dict())
    seen = Seen("a", ("lift",), {}, 0)
    save_other_task(tmp_path / "variants" / "any_task" / "prior", prior, seen)
    start = start_of("spirl", models, params, 0)
    observation = torch.randn(64, 3)
    blind = start.actor.prior(observation)
    torch.testing.assert_close(start.actor.policy(observation), blind)
    moved = observation.clone()
    moved[:, 1] += 1.0  # goal_pos, which the prior knows nothing of
    torch.testing.assert_close(start.actor.prior(moved), blind)
    optimizer = torch.optim.Adam([p for p in start.actor.policy.parameters() if p.requires_grad])
    for _ in range(300):  # to answer with the goal
        optimizer.zero_grad()
        mu, _ = start.actor.policy(observation)
        loss = (mu[:, 0] - observation[:, 1]).square().mean()
        loss.backward()
        optimizer.step()
    assert float(loss.detach()) < 0.1
    save_policy(tmp_path / "policy", start.actor, {})
    again, _ = load_policy(tmp_path / "policy")
    torch.testing.assert_close(again.policy(observation), start.actor.policy(observation))
    torch.testing.assert_close(again.prior(observation), blind)


def test_a_missing_ablation_is_named(models, params):
    with pytest.raises(DataError, match="make paper"):
        start_of("shared_vae", models, params, 0)
