"""What each method begins with, from models in folders; and SAC, which begins with nothing."""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.errors import DataError, UnknownNameError
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.library import transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.tasks import task as task_named
from lfr.transfer.distribution import SQUASHED
from lfr.transfer.loop import TransferLoop
from lfr.transfer.methods import METHODS, initialize
from lfr.transfer.methods.initialization import TrainedModels
from lfr.transfer.model import LearnedFiles, load_policy, save_policy
from tests.skills.made_up import save_models

from .point import NAMES, PointSimulation
from .saved_models import saved_models


@pytest.fixture
def models(tmp_path: Path) -> TrainedModels:
    return saved_models(tmp_path)


def test_methods_differ_in_phi_and_decoder_alone(models, params):
    observation = torch.randn(5, 3)
    prior, g = models.source_prior(), models.generator()
    decoders = {"lfr": "target", "ap": "source", "no_generator": "target"}
    begun = {name: initialize(name, models, params, 0) for name in decoders}
    for name, initialization in begun.items():
        vae = models.target_vae() if decoders[name] == "target" else models.source_vae()
        z, actor = torch.randn(2, 4), initialization.actor
        torch.testing.assert_close(actor.decoder.carry_out(z), vae.carry_out(z))
        # before any learning, the policy is the prior that it is held near
        torch.testing.assert_close(actor.policy(observation), actor.prior(observation))
    torch.testing.assert_close(begun["lfr"].actor.prior(observation), g(*prior(observation)))
    for name in ("ap", "no_generator"):
        torch.testing.assert_close(begun[name].actor.prior(observation), prior(observation))


def test_critics_see_the_same_units_whatever_the_method(models, params):
    observation = torch.randn(5, 3)
    expected = models.source_prior().normalizer(observation)
    for name in METHODS:
        initialization = initialize(name, models, params, 0)
        torch.testing.assert_close(initialization.normalizer(observation), expected)
        assert initialization.layout_names == NAMES


def test_a_new_policy_depends_on_the_seed_alone(models, params):
    observation = torch.randn(5, 3)
    one, again, other = (initialize("sac", models, params, seed) for seed in (3, 3, 4))
    found = [begun.actor.policy(observation)[0] for begun in (one, again, other)]
    assert torch.equal(found[0], found[1])
    assert not torch.equal(found[0], found[2])
    assert not one.actor.prior(observation)[0].any()


def test_methods_of_ones_own_stand_in_the_librarys_place(models, params):
    mine = {"mine": METHODS["ap"]}
    begun, ap = initialize("mine", models, params, 0, mine), initialize("ap", models, params, 0)
    observation = torch.randn(5, 3)
    torch.testing.assert_close(begun.actor.policy(observation), ap.actor.policy(observation))
    with pytest.raises(UnknownNameError, match="unknown method 'lfr'; valid: mine"):
        initialize("lfr", models, params, 0, mine)


def test_sac_acts_step_by_step_within_bounds(models, params, tmp_path):
    actor = initialize("sac", models, params, 0).actor
    assert actor.distribution == SQUASHED
    observations = 50.0 * np.random.default_rng(0).standard_normal((6, 3))
    assert np.shape(actor.act_all(observations)) == (6, 1, 2)
    noisy = actor.choose(torch.randn(500, 3), torch.Generator().manual_seed(0)).z
    assert noisy.abs().max() <= 1.0
    assert noisy.std() > 0.3  # a new policy tries everything
    save_policy(tmp_path / "policy", actor, {})
    again, _ = load_policy(tmp_path / "policy")
    assert again.distribution == SQUASHED
    np.testing.assert_allclose(again.act_all(observations), actor.act_all(observations))


def test_sac_learns_a_trivial_task(models, params):
    learning = dataclasses.replace(
        params, steps=1500, warm_up=200, replay=2000, updates_per_skill=1.0, batch=64,
        policy_lr=3e-3, critic_lr=3e-3, policy_every=1, tau=0.05, gamma=0.9, reward="dense",
        dense_scale=1.0, target_divergence=2 * (1 + math.log(2)), evaluation_episodes=20,
        evaluate_every=500, critic_hidden=(32, 32),
    )  # fmt: skip
    initialization = initialize("sac", models, learning, 0)
    simulations = [PointSimulation() for _ in range(learning.simulations)]
    curve = TransferLoop(initialization, simulations, learning, 0).run()
    assert curve[-1].success >= 0.9


def test_a_network_that_nobody_registered_is_named_with_the_known_ones(models, params, tmp_path):
    """As a study's policy is where the study is not: no traceback, no guess."""
    save_policy(tmp_path / "policy", initialize("ap", models, params, 0).actor, {})
    file = tmp_path / "policy" / "config.json"
    config = json.loads(file.read_text())
    config["networks"]["phi"]["class"] = "SomebodysMap"
    file.write_text(json.dumps(config))
    with pytest.raises(DataError) as raised:
        load_policy(tmp_path / "policy")
    assert str(raised.value).startswith(
        f"an unknown kind of network: {file}, found SomebodysMap, expected SkillPrior or Generator "
        "or SkillVAE or ResizedVAE or IdentityMap or StandardNormal or OneAction"
    )


def test_ap_has_the_target_do_the_sources_actions_joint_by_joint(params, tmp_path):
    """Panda has seven joints, UR5e six; the gripper comes last on either."""
    arms = ("ur5e-joint_position", "panda-joint_position")
    (transfer,) = transfers_of(scenario := Scenario("s", ("lift",), {arms[0]: "stack"}, arms))
    skills = transfer_models(scenario, transfer, tmp_path / "skills")
    names = task_named("stack").observation.names
    save_models(skills["source"], SkillVAE(4, 8, 3, 8), {"stack": SkillPrior(names, 3, 8, 2)})
    save_models(skills["target"], SkillVAE(4, 7, 3, 8), {})
    models = TrainedModels(transfer, skills, tmp_path / "mapping")
    actor = initialize("ap", models, params, 0).actor
    save_policy(tmp_path / "policy", actor, {"robot": arms[0]})
    again = LearnedFiles(str(tmp_path / "policy")).load(arms[0])
    z, seen = torch.randn(5, 3), torch.randn(5, len(names))
    own = torch.stack(models.source_vae().requires_grad_(False).carry_out(z, seen)).numpy()
    for decoder in (actor.decoder, again.decoder):
        found = torch.stack(list(decoder.carry_out(z, seen))).numpy()
        np.testing.assert_array_equal(found, np.delete(own, 6, axis=-1))


def test_a_policy_of_another_robot_is_refused(models, params, tmp_path):
    files = LearnedFiles(str(tmp_path / "policy"))
    actor = initialize("lfr", models, params, 0).actor
    save_policy(tmp_path / "policy", actor, {"robot": "panda-joint_position"})
    assert files.load("panda-joint_position").decoder.latent_dim == 4
    with pytest.raises(DataError, match=r"of another robot: .*found panda-joint_position"):
        files.load("panda")
