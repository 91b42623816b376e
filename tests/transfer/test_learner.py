"""One update against the same update written out with torch's own pieces."""

import copy
import dataclasses

import pytest
import torch
from torch import Tensor, nn
from torch.distributions import Normal
from torch.distributions.kl import kl_divergence

from lfr.errors import ParameterError
from lfr.records import from_mapping
from lfr.transfer.distribution import GAUSSIAN, SQUASHED, tempered
from lfr.transfer.learner import Learner
from lfr.transfer.replay import Batch
from lfr.transfer.transfer_params import TransferParams

from .point import lfr_initialization
from .test_critic import member


def _batch(actor, size: int = 12) -> Batch:
    observation, after = torch.randn(size, 3), torch.randn(size, 3)
    with torch.no_grad():
        prior, next_prior = actor.prior(observation), actor.prior(after)
    discount = torch.where(torch.rand(size) < 0.3, 0.0, 0.99)
    z, reward = torch.randn(size, 2), torch.rand(size)
    return Batch(observation, z, reward, discount, after, *prior, *next_prior)


def _learner(artifacts, params, **changes):
    torch.manual_seed(0)
    start = lfr_initialization(artifacts, dataclasses.replace(params, **changes))
    # Away from the prior, so that the divergence of Eq. 9 is not zero.
    with torch.no_grad():
        for parameter in start.actor.policy.parameters():
            parameter.add_(0.1 * torch.randn_like(parameter))
    generator = torch.Generator().manual_seed(7)
    params = dataclasses.replace(params, **changes)
    return start.actor, Learner(start.actor.policy, start.normalizer, 3, 2, params, generator)


def test_an_update_is_that_of_equation_9(artifacts, params):
    actor, learner = _learner(artifacts, params, policy_every=1, initial_alpha=0.3)
    batch = _batch(actor)
    learner.target.vector.add_(0.1)  # so that it is told from the critics
    policy = copy.deepcopy(actor.policy)
    critics, target = (
        nn.ModuleList(member(c, e) for e in range(2)) for c in (learner.critics, learner.target)
    )

    def values(ensemble: nn.ModuleList, observation: Tensor, z: Tensor) -> Tensor:
        x = torch.cat([learner.critics.inputs(observation), z], -1)
        return torch.stack([one(x).squeeze(-1) for one in ensemble])

    noise = torch.randn(2, 12, 2, generator=torch.Generator().manual_seed(7))

    def divergence(mu: Tensor, log_sigma: Tensor, observation: Tensor) -> Tensor:
        prior_mu, prior_log_sigma = actor.prior(observation)
        return kl_divergence(
            Normal(mu, log_sigma.exp()), Normal(prior_mu, prior_log_sigma.exp())
        ).sum(-1)

    with torch.no_grad():
        mu, log_sigma = policy(batch.next_observation)
        q = values(target, batch.next_observation, mu + log_sigma.exp() * noise[0]).min(0).values
        kl = divergence(mu, log_sigma, batch.next_observation)
        y = batch.reward + batch.discount * (q - 0.3 * kl)
    adam = torch.optim.Adam(critics.parameters(), lr=params.critic_lr)
    loss = sum(
        torch.nn.functional.mse_loss(q, y) for q in values(critics, batch.observation, batch.z)
    )
    assert isinstance(loss, Tensor)
    loss.backward()
    adam.step()

    adam = torch.optim.Adam(policy.parameters(), lr=params.policy_lr)
    mu, log_sigma = policy(batch.observation)
    q = values(critics, batch.observation, mu + log_sigma.exp() * noise[1]).min(0).values
    kl = divergence(mu, log_sigma, batch.observation).mean()
    (0.3 * kl - q.mean()).backward()
    adam.step()

    (info,) = learner.update(batch)
    assert info["critic_loss"].item() == pytest.approx(float(loss.detach()), rel=1e-4)
    assert info["kl"].item() == pytest.approx(float(kl.detach()), rel=1e-4)
    assert info["kl"] > 0.01
    for one, other in zip(actor.policy.parameters(), policy.parameters(), strict=True):
        torch.testing.assert_close(one, other, rtol=1e-3, atol=1e-5)
    for e in range(2):
        pairs = zip(member(learner.critics, e).parameters(), critics[e].parameters(), strict=True)
        for one, other in pairs:
            torch.testing.assert_close(one, other, rtol=1e-3, atol=1e-5)
        of_target = [m.parameters() for m in (member(learner.target, e), target[e], critics[e])]
        for moved, old, new in zip(*of_target, strict=True):
            torch.testing.assert_close(moved, old + params.tau * (new - old), rtol=1e-3, atol=1e-5)
    direction = 1 if kl.detach() > params.target_divergence else -1
    assert (learner.temperature().item() - 0.3) * direction > 0


def test_one_state_that_the_prior_never_saw_does_not_decide_for_all(artifacts, params):
    """There the prior is sure, so a small difference is a divergence of a million nats."""

    def after(limit: float) -> tuple[float, float]:
        actor, learner = _learner(artifacts, params, policy_every=1, divergence_limit=limit)
        batch = _batch(actor)
        batch.prior_log_sigma[0] = batch.next_prior_log_sigma[0] = -7.0
        mu, log_sigma = actor.policy(batch.observation)
        kl = learner.distribution.divergence(
            mu, log_sigma, mu, batch.prior_mu, batch.prior_log_sigma
        )
        assert kl[0] > 10_000 > 1_000 * kl[1:].max()
        (info,) = learner.update(batch)
        pull = learner.policy_adam.mean.norm()  # of a first step: the gradient, scaled
        return float(info["critic_loss"]), float(pull)

    loss, pull = after(0.0)
    tempered_loss, tempered_pull = after(15.0)
    assert tempered_loss < 0.01 * loss
    assert tempered_pull < 0.01 * pull


def test_policy_waits_its_turn_and_warm_up_leaves_it(artifacts, params):
    actor, learner = _learner(artifacts, params, policy_every=3)
    before = learner.policy_adam.flat.clone()
    moved = []
    for i in range(6):
        (info,) = learner.update(_batch(actor), critics_only=i == 2)
        moved.append(not torch.equal(before, learner.policy_adam.flat))
        assert ("kl" in info) == (i == 5)
    assert moved == [False] * 5 + [True]


@pytest.mark.parametrize("policy_every", [1, 2, 3])
@pytest.mark.parametrize("critics_only", [False, True])
def test_steps_at_once_are_steps_one_by_one(
    artifacts, params, policy_every, critics_only, monkeypatch
):
    noise = torch.randn(2, 7 * 12, 2)

    class Dealt:
        """The same noise for the same rows, however many are drawn at once."""

        def __init__(self) -> None:
            self.rows = 0

        def __call__(self, *shape, generator):
            first, self.rows = self.rows, self.rows + shape[1]
            return noise[:, first : self.rows]

    ends = []
    for counts in ([1] * 7, [7], [2, 5]):
        actor, learner = _learner(artifacts, params, policy_every=policy_every)
        parts, infos = [_batch(actor) for _ in range(7)], []
        with monkeypatch.context() as patch:
            patch.setattr(torch, "randn", Dealt())
            for count in counts:
                some, parts = parts[:count], parts[count:]
                together = Batch(*(torch.cat(columns) for columns in zip(*some, strict=True)))
                infos += learner.update(together, count, critics_only=critics_only)
        ends.append((learner.state(), [sorted(info) for info in infos]))
    for state, kinds in ends[1:]:
        assert kinds == ends[0][1]
        for name, value in state.items():
            if name != "random":
                torch.testing.assert_close(value, ends[0][0][name], rtol=1e-3, atol=1e-5)


def test_fixed_alpha_stays(artifacts, params):
    actor, learner = _learner(artifacts, params, policy_every=1, fixed_alpha=True)
    learner.update(_batch(actor))
    assert learner.temperature().item() == pytest.approx(params.initial_alpha)


def test_a_random_subset_bounds_the_target_from_above(artifacts, params):
    """REDQ: the minimum over two of five critics is no lower than over all, and often the same."""
    actor, learner = _learner(artifacts, params, critics=5, target_subset=2)
    batch, alpha = _batch(actor), learner.temperature()
    later = learner.see(batch.next_observation)
    prior = batch.next_prior_mu, batch.next_prior_log_sigma
    ahead = learner.foresee(later.policy, torch.zeros(12, 2), *prior)
    some = [learner.targets(batch, alpha, later.critics, *ahead) for _ in range(20)]
    learner.params = dataclasses.replace(learner.params, target_subset=0)
    everyone = learner.targets(batch, alpha, later.critics, *ahead)
    assert all((one >= everyone - 1e-6).all() for one in some)
    assert any((one > everyone + 1e-6).any() for one in some)


def test_parameters_are_held_to_their_ranges():
    assert from_mapping(TransferParams, {}, "transfer") == TransferParams()
    with pytest.raises(ParameterError, match="gamma"):
        TransferParams(gamma=1.5)
    with pytest.raises(ParameterError, match="target_subset"):
        TransferParams(critics=2, target_subset=3)
    with pytest.raises(ParameterError, match="steps"):
        TransferParams(steps=0)
    with pytest.raises(ParameterError, match="batch"):
        TransferParams(batch=64, replay=10)


@pytest.mark.parametrize("target_subset", [0, 2])
def test_the_policy_climbs_what_autograd_says(artifacts, params, target_subset):
    _, learner = _learner(artifacts, params, critics=5, target_subset=target_subset)
    q = torch.randn(5, 12, requires_grad=True)
    expected = q.mean() if target_subset else q.min(0).values.mean()
    value, slope = learner.value(q.detach())
    torch.testing.assert_close(value, expected.detach())
    torch.testing.assert_close(slope, torch.autograd.grad(expected, q)[0])


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("drawn_from", [GAUSSIAN, SQUASHED])
@pytest.mark.parametrize(
    "changes",
    [{}, {"divergence_limit": 0.5, "min_sigma": 0.3}, {"divergence_limit": 0.0, "train_phi": False},
     {"critics": 5, "target_subset": 2}, {"layer_norm": False, "fixed_alpha": True}],
)  # fmt: skip
def test_the_policys_gradient_is_autograds_of_equation_9(
    artifacts, params, changes, drawn_from, dtype
):
    """Policy, critics and what is climbed as one function of the policy's parameters."""
    changed = dataclasses.replace(params, **changes)
    torch.manual_seed(0)
    start = lfr_initialization(artifacts, changed)
    policy = start.actor.policy.to(dtype)
    with torch.no_grad():
        for parameter in policy.parameters():
            parameter.add_(0.2 * torch.randn_like(parameter))
    reference = copy.deepcopy(policy)
    learner = Learner(policy, start.normalizer, 3, 2, changed, torch.Generator(), drawn_from)
    critics, alpha = learner.critics, torch.tensor(0.3, dtype=dtype)
    critics.normalizer.to(dtype)
    critics._hold(torch.randn_like(critics.vector, dtype=dtype))
    observation, noise, *prior = (torch.randn(12, n, dtype=dtype) for n in (3, 2, 2, 2))

    mu, log_sigma = reference(observation)
    z = drawn_from.skill(mu, log_sigma, noise)
    x = torch.cat([critics.inputs(observation), z], -1)
    q = torch.stack([member(critics, e)(x).squeeze(-1) for e in range(changed.critics)])
    value = q.mean() if changed.target_subset else q.min(0).values.mean()
    kl = drawn_from.divergence(mu, log_sigma, noise, *prior)
    kl = tempered(kl, changed.divergence_limit)[0]
    assert not changes.get("divergence_limit") or (kl > changed.divergence_limit).any()
    learns = [p for p in reference.parameters() if p.requires_grad]
    wanted = torch.autograd.grad(0.3 * kl.mean() - value, learns)

    found: list[Tensor] = []
    learner.policy_adam.descend = lambda gradient: found.append(gradient.clone())
    learner.alpha_adam.descend = lambda gradient: None
    nothing = torch.zeros(12, dtype=dtype)
    batch = Batch(observation, z, nothing, nothing, observation, *prior, *prior)
    info = learner.improve(batch, learner.see(observation), alpha, noise)
    near = 1e-10 if dtype == torch.float64 else 1e-3
    expected = torch.cat([g.t().reshape(-1) for g in wanted])
    torch.testing.assert_close(found[0], expected, rtol=near, atol=0.1 * near)
    torch.testing.assert_close(info["policy_loss"], (0.3 * kl.mean() - value).detach())
    torch.testing.assert_close(info["kl"], kl.mean().detach())
