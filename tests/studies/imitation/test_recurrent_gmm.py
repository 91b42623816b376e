"""The mixture against torch.distributions, and a state that carries what has been seen."""

import torch
from torch.distributions import Categorical, Independent, MixtureSameFamily, Normal

from studies.imitation.recurrent_gmm import Mixture
from tests.studies.imitation.made_up import NAMES, network


def test_log_likelihood_is_that_of_torch_distributions() -> None:
    generator = torch.Generator().manual_seed(1)
    logits = 3.0 * torch.randn(5, 4, 3, generator=generator)
    means = torch.randn(5, 4, 3, 7, generator=generator)
    scales = 1e-3 + torch.rand(5, 4, 3, 7, generator=generator)
    actions = torch.randn(5, 4, 7, generator=generator)
    expected = MixtureSameFamily(
        Categorical(logits=logits), Independent(Normal(means, scales), 1)
    ).log_prob(actions)
    found = Mixture(logits, means, scales).log_likelihood(actions)
    assert found.shape == (5, 4)
    torch.testing.assert_close(found, expected)


def test_shapes_and_bounds() -> None:
    policy = network()
    mixture, _ = policy(10.0 * torch.randn(5, 7, len(NAMES)))
    assert mixture.logits.shape == (5, 7, policy.modes)
    assert mixture.means.shape == mixture.scales.shape == (5, 7, policy.modes, 2)
    assert float(mixture.means.detach().abs().max()) <= 1.0
    assert float(mixture.scales.detach().min()) >= policy.min_std


def test_step_by_step_is_the_whole_sequence() -> None:
    policy = network()
    observations = torch.randn(2, 6, len(NAMES))
    whole, _ = policy(observations)
    hidden = None
    for t in range(6):
        step, hidden = policy(observations[:, t : t + 1], hidden)
        torch.testing.assert_close(step.means[:, 0], whole.means[:, t])
        torch.testing.assert_close(step.logits[:, 0], whole.logits[:, t])


def test_an_action_depends_on_the_past_and_not_on_the_future() -> None:
    policy = network()
    observations = torch.randn(1, 6, len(NAMES))
    changed = observations.clone()
    changed[:, 3] += 1.0
    (before, _), (after, _) = policy(observations), policy(changed)
    assert torch.equal(before.means[:, :3], after.means[:, :3])
    assert not torch.isclose(before.means[:, 3:], after.means[:, 3:]).all(-1).any()
