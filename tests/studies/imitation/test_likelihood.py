"""Cloning what can be cloned, the same from the same seed, and what is kept of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.errors import DataError, ParameterError
from lfr.skills.saved_models import Seen
from studies.imitation.imitation_params import ImitationParams
from studies.imitation.likelihood import log_likelihood, train_bc
from studies.imitation.recurrent_policy import RecurrentPolicy
from studies.imitation.saved_policies import load_policy, load_seen, save_policy
from tests.studies.imitation.made_up import NAMES, SMALL, demonstrations, network


def test_learns_to_say_what_it_sees() -> None:
    recorded, unseen = demonstrations((40,) * 10), demonstrations((40,), seed=1)
    trained = train_bc(recorded, replace(SMALL, updates=400), seed=0)
    policy = RecurrentPolicy(trained)
    said = np.concatenate([policy.act(observation.numpy()) for observation in unseen.observations])
    errors = np.abs(said - unseen.actions.numpy())
    assert errors.mean() < 0.1  # an action that ignores what it sees is off by 0.45
    first, last = train_bc(recorded, SMALL, seed=0), trained
    before, after = log_likelihood(first, unseen), log_likelihood(last, unseen)
    assert before is not None
    assert after is not None
    assert after > before + 1.0


def test_same_seed_same_weights() -> None:
    recorded = demonstrations((8, 5))
    one, same, other = (train_bc(recorded, SMALL, seed).state_dict() for seed in (3, 3, 4))
    assert all(torch.equal(one[name], same[name]) for name in one)
    assert not torch.equal(one["output.weight"], other["output.weight"])


def test_denormal_numbers_are_as_they_were_after_training() -> None:
    train_bc(demonstrations((8,)), SMALL, seed=0)
    assert float(torch.tensor(1e-39) * 1.0) > 0.0


def test_held_out_likelihood_is_a_mean_over_sequences_and_steps() -> None:
    policy, recorded = network(), demonstrations((12, 3))
    nothing, _ = recorded.split(0.0, 0)[::-1]
    assert log_likelihood(policy, nothing) is None
    one_by_one = []
    for first, end in ((0, 12), (12, 15)):
        for start in range(first, end):
            rows = torch.arange(start, start + policy.horizon).clamp(max=end - 1)
            mixture, _ = policy(recorded.observations[rows][None])
            one_by_one.append(mixture.log_likelihood(recorded.actions[rows][None]).mean())
    expected = float(torch.stack(one_by_one).mean().detach())
    assert log_likelihood(policy, recorded) == pytest.approx(expected, rel=1e-5)


def test_saved_and_loaded_it_acts_alike_and_says_what_it_saw(tmp_path: Path) -> None:
    policy = train_bc(demonstrations((8, 5)), SMALL, seed=0)
    seen = Seen("sawyer", ("lift",), {"sawyer-lift": "ab"}, 7)
    save_policy(tmp_path / "policy", policy, seen)
    loaded = load_policy(tmp_path / "policy", NAMES)
    assert load_seen(tmp_path / "policy") == seen
    observation = np.array([0.1, -0.2, 0.3])
    acted = [RecurrentPolicy(one).act(observation) for one in (policy, loaded)]
    assert np.array_equal(*acted)
    assert loaded.horizon == SMALL.horizon
    with pytest.raises(DataError, match="another state layout"):
        load_policy(tmp_path / "policy", NAMES[:2])


def test_parameters_that_cannot_be() -> None:
    with pytest.raises(ParameterError, match="modes must be at least 1, found 0"):
        ImitationParams(modes=0)
    with pytest.raises(ParameterError, match="above 0"):
        ImitationParams(min_std=0.0)
