"""Acting: what is remembered, for how long, and which mode is done."""

import numpy as np
import torch

from studies.imitation.recurrent_policy import RecurrentPolicy
from tests.studies.imitation.made_up import NAMES, network

SEEN = np.array([0.1, -0.2, 0.3])


def single_mode() -> RecurrentPolicy:
    """Always the first mode, so that an action tells the hidden state alone."""
    policy = network()
    with torch.no_grad():
        policy.output.bias[: policy.modes] = torch.tensor([100.0, 0.0, 0.0])
    return RecurrentPolicy(policy)


def test_actions_have_a_control_step_and_are_deterministic_after_a_reset() -> None:
    policy = RecurrentPolicy(network())
    policy.reset(5)
    first = [policy.act(SEEN) for _ in range(13)]
    policy.reset(5)
    again = [policy.act(SEEN) for _ in range(13)]
    assert first[0].shape == (1, 2)
    assert np.array_equal(first, again)


def test_memory_lasts_for_ten_steps() -> None:
    policy = single_mode()
    acted = [policy.act(SEEN) for _ in range(2 * policy.network.horizon)]
    assert policy.network.horizon == 10
    assert all(not np.array_equal(acted[0], acted[t]) for t in range(1, 10))
    assert np.array_equal(acted[:10], acted[10:])


def test_memory_ends_with_the_episode() -> None:
    policy = single_mode()
    first = policy.act(SEEN)
    policy.act(SEEN)
    policy.reset()
    assert np.array_equal(policy.act(SEEN), first)
    second = [policy.act(SEEN) for _ in range(9)]
    assert not np.array_equal(second[-1], first)  # the count of ten began anew too
    assert np.array_equal(policy.act(SEEN), first)


def test_the_action_is_the_mean_of_a_mode_as_often_as_its_weight_says() -> None:
    network_ = network()
    with torch.no_grad():
        network_.output.weight[: network_.modes] = 0.0
        network_.output.bias[: network_.modes] = torch.tensor([0.5, 0.3, 0.2]).log()
    policy = RecurrentPolicy(network_)
    mixture, _ = network_(torch.as_tensor(SEEN, dtype=torch.float32).reshape(1, 1, len(NAMES)))
    means = mixture.means[0, 0].detach().double().numpy()
    counts = np.zeros(3)
    for seed in range(500):
        policy.reset(seed)
        counts += np.all(policy.act(SEEN) == means, axis=1)
    assert counts.sum() == 500
    assert np.abs(counts / 500 - [0.5, 0.3, 0.2]).max() < 0.08  # standard error 0.022
