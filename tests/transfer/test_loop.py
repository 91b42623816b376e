"""The loop: what it stores, that it learns, is determined, and loses nothing by a kill."""

import dataclasses
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.errors import DataError, LfrError, UnknownNameError
from lfr.seeds import use_of_seed
from lfr.transfer.environment import RewardRule, RunningEpisode
from lfr.transfer.loop import TransferLoop
from lfr.transfer.methods import method
from lfr.transfer.model import load_policy, save_policy
from lfr.transfer.observer import Observer

from .point import PointSimulation, lfr_initialization


def _loop(artifacts, params, *, seed=0, work=None, observer=None, **options):
    start = lfr_initialization(artifacts, params)
    simulations = [PointSimulation(**options) for _ in range(params.simulations)]
    return TransferLoop(start, simulations, params, seed, work, observer)


def _weights(loop):
    return [p.detach().clone() for p in loop.actor.policy.parameters()]


def _same(one, other):
    assert one.curve == other.curve
    for a, b in zip(_weights(one), _weights(other), strict=True):
        assert torch.equal(a, b)
    states = [loop.learner.state() | loop.replay.state() for loop in (one, other)]
    for name, value in states[0].items():
        assert torch.equal(value, states[1][name]), name


def test_terminals_end_the_return_and_time_limits_bootstrap(artifacts, params):
    loop = _loop(artifacts, params)
    loop.run()
    rows, size = loop.replay.rows, len(loop.replay)
    parts = rows[:size].split(loop.replay.widths, dim=1)
    reward, discount = parts[2].squeeze(1), parts[3].squeeze(1)
    assert (reward == 1).any()
    assert (reward == 0).any()
    assert (discount[reward == 1] == 0).all()
    assert (discount[reward == 0] == params.gamma).all()  # an episode of 8 steps has a time limit


def test_dense_reward_runs_on_after_success_and_never_ends_the_return(artifacts, params):
    dense = dataclasses.replace(params, reward="dense")
    lengths = []

    class Listen(Observer):
        def on_episode(self, episode):
            lengths.append((episode.length, episode.success))

    loop = _loop(artifacts, dense, observer=Listen())
    loop.run()
    parts = loop.replay.rows[: len(loop.replay)].split(loop.replay.widths, dim=1)
    assert (parts[3] == params.gamma).all()
    assert {length for length, _ in lengths} == {8}


def test_a_skill_is_cut_at_the_time_limit_and_its_rewards_are_summed():
    episode = RunningEpisode(PointSimulation(horizon=8))
    episode.start(1)
    rule = RewardRule("dense", 0.5)
    still = np.zeros((3, 2))
    outcomes = [episode.execute(still + 0.1, rule) for _ in range(3)]
    assert [o.steps for o in outcomes] == [3, 3, 2]
    assert [o.over for o in outcomes] == [False, False, True]
    assert not any(o.terminated for o in outcomes)
    goal = episode.simulation.goal  # type: ignore[attr-defined]
    rewards = [max(0.0, 1 - abs(goal - 0.05 * (t + 1))) for t in range(3)]
    assert outcomes[0].reward == pytest.approx(0.5 * sum(rewards))


def test_a_diverged_simulation_is_not_learned_from(artifacts, params):
    valid = []

    class Listen(Observer):
        def on_episode(self, episode):
            valid.append(episode.valid)

    loop = _loop(artifacts, params, observer=Listen(), diverge_at=1)
    loop.run()
    assert len(loop.replay) == 0
    assert valid
    assert not any(valid)


def test_every_step_is_on_the_axis_and_updates_follow_the_ratio(artifacts, params):
    steps, updates = [], []

    class Listen(Observer):
        def on_episode(self, episode):
            steps.append(episode.length)
            assert use_of_seed(episode.seed) == "learning"

        def on_update(self, env_steps, count, info):
            updates.append((env_steps, count, set(info)))

    loop = _loop(artifacts, params, observer=Listen())
    curve = loop.run()
    running = sum(episode.length for episode in loop.episodes)
    assert loop.progress.env_steps == sum(steps) + running
    # A round's updates are those that were due before it.
    learned = loop.progress.skills - params.simulations - loop.progress.skills_before_updates
    assert loop.progress.updates == int(params.updates_per_skill * learned)
    for env_steps, _, names in updates:  # warm-up: only the critics learn, and it counts
        assert ("kl" in names) <= (env_steps >= params.warm_up)
    assert any("kl" in names for _, _, names in updates)
    assert curve[0].env_steps == 0
    assert curve[-1].env_steps >= params.steps


@pytest.mark.parametrize("reward", ["sparse", "dense"])
def test_a_trivial_task_is_learned(artifacts, params, reward):
    """The prior knows nothing and hardly ever succeeds by its mean; a few seconds later it does."""
    learning = dataclasses.replace(
        params, steps=1200, reward=reward, dense_scale=0.1, target_divergence=8.0,
        initial_alpha=0.01, policy_lr=3e-3, critic_lr=3e-3, replay=2000, critic_hidden=(32, 32),
        evaluate_every=1200, evaluation_episodes=20, simulations=4,
    )  # fmt: skip
    curve = _loop(artifacts, learning).run()
    assert curve[0].success < 0.7
    assert curve[-1].success >= 0.95


def test_the_same_seed_gives_the_same_run_and_another_does_not(artifacts, params):
    one, other, third = (_loop(artifacts, params, seed=seed) for seed in (1, 1, 2))
    for loop in (one, other, third):
        torch.randn(3)  # the global random state is nobody's business
        loop.run()
    _same(one, other)
    assert not torch.equal(_weights(one)[0], _weights(third)[0])


def test_listening_changes_nothing(artifacts, params):
    one, other = _loop(artifacts, params), _loop(artifacts, params, observer=Observer())
    one.run()
    other.run()
    _same(one, other)


def test_killed_and_resumed_equals_uninterrupted(artifacts, params, tmp_path):
    package = str(__package__)
    root = Path(__file__).parents[len(package.split("."))]
    child = subprocess.run(
        [sys.executable, "-m", f"{package}.killed_run", str(tmp_path / "killed")],
        cwd=root,
        check=False,
    )
    assert child.returncode == -signal.SIGKILL
    assert len(list((tmp_path / "killed").glob("checkpoint-*"))) == 1
    resumed = _loop(artifacts, params, work=tmp_path / "killed")
    assert 60 <= resumed.progress.env_steps < 80
    whole = _loop(artifacts, params, work=tmp_path / "whole")
    without = _loop(artifacts, params)  # that checkpoints are written changes nothing either
    for loop in (resumed, whole, without):
        loop.run()
    _same(whole, resumed)
    _same(whole, without)


def test_a_checkpoint_of_another_run_is_refused(artifacts, params, tmp_path):
    _loop(artifacts, params, work=tmp_path).run()
    with pytest.raises(DataError, match="another run"):
        _loop(artifacts, params, seed=5, work=tmp_path)


def test_saved_policy_acts_identically(artifacts, params, tmp_path):
    # the decoder of the tests is no class that a model folder knows
    from lfr.skills.vae import SkillVAE

    vae = SkillVAE(horizon=3, action_dim=7, latent_dim=2, hidden=8)
    real = artifacts._replace(target_vae=vae)
    loop = _loop(real, dataclasses.replace(params, min_sigma=2.0))
    loop.run()
    save_policy(tmp_path / "model", loop.actor, {"method": "lfr", "params": params})
    actor, about = load_policy(tmp_path / "model")
    observations = np.random.default_rng(0).normal(size=(5, 3))
    assert np.array_equal(actor.act_all(observations), loop.actor.act_all(observations))
    assert np.shape(actor.act_all(observations)) == (5, 3, 7)
    assert np.allclose(actor.act(observations[0]), actor.act_all(observations)[0], atol=1e-6)
    tensor = torch.tensor(observations, dtype=torch.float32)
    for found, saved in ((actor.prior, loop.actor.prior), (actor.policy, loop.actor.policy)):
        for one, other in zip(found(tensor), saved(tensor), strict=True):
            assert torch.equal(one, other)
        assert (found(tensor)[1].exp() > 2.0).all()  # what the artifacts say is less
    assert about["params"]["steps"] == params.steps


def test_bad_input_is_named(artifacts, params):
    with pytest.raises(UnknownNameError, match="unknown method 'lrf'; valid: lfr"):
        method("lrf")
    with pytest.raises(LfrError, match="found 1 simulations, expected 2"):
        TransferLoop(lfr_initialization(artifacts, params), [PointSimulation()], params, 0)
