"""Soft actor-critic in the latent space of skills, its entropy replaced by Eq. 9 (Algorithm 2)."""

from __future__ import annotations

import copy
from typing import NamedTuple

import torch
from torch import Tensor, nn

from lfr.networks.device import CPU
from lfr.networks.optimizer import FlatAdam
from lfr.transfer.critic import CriticEnsemble, critic_loss, pessimistic, td_target
from lfr.transfer.distribution import GAUSSIAN, Distribution, tempered
from lfr.transfer.extended_policy import MappedPolicy
from lfr.transfer.learning_policy import LearningPolicy
from lfr.transfer.replay import Batch
from lfr.transfer.temperature import Temperature
from lfr.transfer.transfer_params import TransferParams

Info = dict[str, Tensor]


class Inputs(NamedTuple):
    """What the networks make of observations before their first parameters."""

    critics: Tensor  # (B, inputs)
    policy: Tensor  # (B, features)


class Learner:
    """Policy, critics, target critics and temperature, and how one batch changes them.

    The policy goes to the device and its parameters become views into one vector, in place: the
    caller's policy is the one that learns.

    Args:
        policy: pi' = phi o pi (Eq. 7), observations (B, D) to (mu, log_sigma).
        normalizer: maps raw observations (B, D) to unit scale for the critics.
        generator: all of the update's noise comes from it; on the CPU, as batches may be.
        distribution: how the policy's (mu, log_sigma) become a skill.
        device: where all this is computed.
    """

    def __init__(
        self,
        policy: MappedPolicy,
        normalizer: nn.Module,
        observation_dim: int,
        latent_dim: int,
        params: TransferParams,
        generator: torch.Generator,
        distribution: Distribution = GAUSSIAN,
        device: torch.device = CPU,
    ) -> None:
        self.params, self.generator, self.distribution = params, generator, distribution
        self.device, self.policy = device, LearningPolicy(policy.to(device))
        inputs = normalizer(torch.zeros(1, observation_dim)).shape[-1]  # may hold more than D
        self.critics = CriticEnsemble(
            copy.deepcopy(normalizer), inputs, latent_dim, params.critics,
            params.critic_hidden, layer_norm=params.layer_norm,
        ).to(device)  # fmt: skip
        self.target = self.critics.clone()
        self.temperature = Temperature(params.initial_alpha, device)
        self.policy_adam = FlatAdam(self.policy.vector, params.policy_lr)
        self.critic_adam = FlatAdam(self.critics.vector, params.critic_lr)
        self.alpha_adam = FlatAdam(self.temperature.log_alpha, params.alpha_lr)
        self.updates = 0

    @torch.no_grad()
    def update(self, batch: Batch, count: int = 1, *, critics_only: bool = False) -> list[Info]:
        """``count`` steps of the critics, each on one of as many equal parts of a batch.

        Policy and temperature make a step where one is due. What does not change on the way is
        computed once: what networks see of the observations and, between two steps of the policy,
        what it would do next.

        Returns:
            Of each step scalars that describe it; those of the policy only where it made one.
        """
        noise = torch.randn(2, *batch.z.shape, generator=self.generator).to(self.device)
        batch = Batch(*(column.to(self.device) for column in batch))
        now, later = self.see(batch.observation), self.see(batch.next_observation)
        if len(batch.reward) % count:
            raise ValueError(f"a batch of {len(batch.reward)} has no {count} equal parts")
        size, every = len(batch.reward) // count, self.params.policy_every
        parts = [Batch(*columns) for columns in zip(*(c.split(size) for c in batch), strict=True)]
        infos: list[Info] = []
        while (first := len(infos)) < count:
            last = count if critics_only else min(count, first + every - self.updates % every)
            alpha, group = self.temperature(), slice(first * size, last * size)
            prior = batch.next_prior_mu[group], batch.next_prior_log_sigma[group]
            ahead = self.foresee(later.policy[group], noise[0][group], *prior)
            steps = (range(first, last), *(x.split(size) for x in ahead))
            for k, next_z, kl in zip(*steps, strict=True):
                rows = slice(k * size, (k + 1) * size)
                target = self.targets(parts[k], alpha, later.critics[rows], next_z, kl)
                infos.append(self.teach(now.critics[rows], parts[k].z, target, alpha))
            if not critics_only and self.updates % every == 0:
                rows = slice((last - 1) * size, last * size)
                seen = Inputs(*(inputs[rows] for inputs in now))
                infos[-1] |= self.improve(parts[last - 1], seen, alpha, noise[1][rows])
        return infos

    def see(self, observation: Tensor) -> Inputs:
        """What the networks see of raw observations (B, D)."""
        return Inputs(self.critics.inputs(observation), self.policy.features(observation))

    def foresee(self, features: Tensor, noise: Tensor, *prior: Tensor) -> tuple[Tensor, Tensor]:
        """The policy's skills (B, Z) in states of these features, and their divergence (B,).

        The divergence is tempered, from the prior's (mu, log_sigma): what Eq. 9 charges.
        """
        mu, log_sigma, _ = self.policy.evaluate(features)
        kl = self.distribution.divergence(mu, log_sigma, noise, *prior)
        z = self.distribution.skill(mu, log_sigma, noise)
        return z, tempered(kl, self.params.divergence_limit)[0]

    def targets(
        self, batch: Batch, alpha: Tensor, next_inputs: Tensor, next_z: Tensor, kl: Tensor
    ) -> Tensor:
        """The TD targets (B,) of a batch, from the target critics."""
        next_q, _ = self.target.values(next_inputs, next_z)
        next_q = pessimistic(next_q, self.subset())
        return td_target(batch.reward, batch.discount, next_q, alpha, kl)

    def teach(self, inputs: Tensor, z: Tensor, target: Tensor, alpha: Tensor) -> Info:
        """One step of the critics, and of the target critics after them."""
        q, traces = self.critics.values(inputs, z)
        loss, slope = critic_loss(q, target)
        self.critic_adam.descend(self.critics.by_parameters(traces, slope))
        self.target.vector.lerp_(self.critics.vector, self.params.tau)
        self.updates += 1
        return {"critic_loss": loss, "q": q.mean(), "alpha": alpha}

    def subset(self) -> Tensor | None:
        """REDQ: the members (target_subset,) whose minimum this update's target takes."""
        if self.params.target_subset == 0:
            return None
        order = torch.randperm(self.params.critics, generator=self.generator)
        return order[: self.params.target_subset]

    def improve(self, batch: Batch, seen: Inputs, alpha: Tensor, noise: Tensor) -> Info:
        """One step of the policy on alpha KL - Q (Eq. 9), and of the temperature.

        The gradient is that of the mean over the batch of alpha tempered(KL(mu, log_sigma)) less
        the value of z = skill(mu, log_sigma, noise), by the chain rule: the value by Q by z, z and
        KL by mu and log_sigma, these by the policy's parameters.
        """
        mu, log_sigma, trace = self.policy.evaluate(seen.policy)
        z = self.distribution.skill(mu, log_sigma, noise)  # reparameterised
        q, traces = self.critics.values(seen.critics, z)
        value, by_q = self.value(q)
        by_z = self.critics.by_skill(traces, -by_q)
        drawn = (mu, log_sigma, noise, batch.prior_mu, batch.prior_log_sigma)
        kl, by_kl = tempered(self.distribution.divergence(*drawn), self.params.divergence_limit)
        slopes = self.distribution.slopes(*drawn, by_z, by_kl * (alpha / len(kl)))
        self.policy_adam.descend(self.policy.by_parameters(trace, *slopes))
        kl = kl.mean()
        if not self.params.fixed_alpha:
            self.alpha_adam.descend(self.temperature.gradient(kl, self.params.target_divergence))
        return {"policy_loss": alpha * kl - value, "kl": kl, "sigma": log_sigma.mean().exp()}

    def value(self, q: Tensor) -> tuple[Tensor, Tensor]:
        """What the policy climbs of the critics' values (E, B), and its gradient by them (E, B).

        SAC climbs the lower of its two critics, REDQ the mean of its ensemble.
        """
        if self.params.target_subset:
            return q.mean(), torch.full_like(q, 1.0 / q.numel())
        lowest = q.min(0)
        slope = torch.zeros_like(q).scatter_(0, lowest.indices[None], 1.0 / q.shape[1])
        return lowest.values.mean(), slope

    def state(self) -> dict[str, Tensor]:
        """Everything that further updates depend on, but the replay buffer."""
        state = {
            "target": self.target.vector.clone(),
            "random": self.generator.get_state(),
            "updates": torch.tensor(self.updates),
        }
        for name, adam in self._optimizers().items():
            state |= {f"{name}.{key}": value for key, value in adam.state().items()}
        return state

    def load_state(self, state: dict[str, Tensor]) -> None:
        self.target.vector.copy_(state["target"])
        self.updates = int(state["updates"])
        self.generator.set_state(state["random"])
        for name, adam in self._optimizers().items():
            prefix = f"{name}."
            adam.load_state(
                {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}
            )

    def _optimizers(self) -> dict[str, FlatAdam]:
        return {
            "policy": self.policy_adam,
            "critics": self.critic_adam,
            "temperature": self.alpha_adam,
        }
