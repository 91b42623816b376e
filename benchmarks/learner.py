"""Updates per second of the transfer learner on one core, and what each of its measures brings.

The other side is the same update in plain eager PyTorch: critics as separate networks, torch.optim
on every tensor, the prior evaluated in every update, the divergence by samples, Polyak averaging
tensor by tensor. Between the two, one measure after another is taken. Rounds of all variants
alternate, so that what else the machine does falls on each alike; times are the process's own.
Writes results/benchmarks/learner.json.
"""

from __future__ import annotations

import argparse
import copy
import dataclasses
import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor, nn

from lfr.artifacts import provenance, write_json
from lfr.mapping.generator import Generator
from lfr.skills.gaussian import kl_divergence, log_probability
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.learner import Learner
from lfr.transfer.methods import Artifacts, method
from lfr.transfer.params import TransferParams
from lfr.transfer.replay import Batch, Replay

OBSERVATION, LATENT = 30, 10  # Stack has 28 dimensions, NutAssembly 30
GOAL_RATE = 250.0  # updates/s on one core, default parameters
ROUND = 40  # updates timed at a time


class PlainLearner:
    """The update of `Learner`, as one writes it first; each flag takes one of its measures."""

    def __init__(
        self, start, params: TransferParams, *, closed_form: bool, cached_prior: bool
    ) -> None:
        self.params, self.closed_form, self.cached_prior = params, closed_form, cached_prior
        self.policy, self.prior = start.actor.policy, start.actor.prior
        self.normalizer = start.normalizer
        self.critics = nn.ModuleList(self._critic() for _ in range(params.critics))
        self.target = copy.deepcopy(self.critics).requires_grad_(False)
        self.log_alpha = nn.Parameter(torch.tensor(params.initial_alpha).log())
        self.critic_adam = torch.optim.Adam(self.critics.parameters(), lr=params.critic_lr)
        self.policy_adam = torch.optim.Adam(self.policy.parameters(), lr=params.policy_lr)
        self.alpha_adam = torch.optim.Adam([self.log_alpha], lr=params.alpha_lr)

    def _critic(self) -> nn.Module:
        layers: list[nn.Module] = []
        width = OBSERVATION + LATENT
        for hidden in self.params.critic_hidden:
            layers.append(nn.Linear(width, hidden))
            if self.params.layer_norm:
                layers.append(nn.LayerNorm(hidden))
            layers.append(nn.ReLU())
            width = hidden
        return nn.Sequential(*layers, nn.Linear(width, 1))

    def _values(self, critics: nn.ModuleList, observation: Tensor, z: Tensor) -> Tensor:
        x = torch.cat([self.normalizer(observation), z], -1)
        return torch.stack([critic(x).squeeze(-1) for critic in critics])

    def _divergence(self, z: Tensor, policy: tuple[Tensor, Tensor], prior: tuple) -> Tensor:
        if self.closed_form:
            return kl_divergence(*policy, *prior)
        return log_probability(z, *policy) - log_probability(z, *prior)

    def _prior(self, observation: Tensor, stored: tuple[Tensor, Tensor]) -> tuple:
        return stored if self.cached_prior else self.prior(observation)

    def update(self, batch: Batch) -> None:
        alpha = self.log_alpha.exp().detach()
        with torch.no_grad():
            mu, log_sigma = self.policy(batch.next_observation)
            z = mu + log_sigma.exp() * torch.randn_like(mu)
            stored = (batch.next_prior_mu, batch.next_prior_log_sigma)
            prior = self._prior(batch.next_observation, stored)
            q = self._values(self.target, batch.next_observation, z).amin(0)
            value = q - alpha * self._divergence(z, (mu, log_sigma), prior)
            y = batch.reward + batch.discount * value
        q = self._values(self.critics, batch.observation, batch.z)
        self.critic_adam.zero_grad()
        (q - y).square().mean(-1).sum().backward()
        self.critic_adam.step()

        mu, log_sigma = self.policy(batch.observation)
        z = mu + log_sigma.exp() * torch.randn_like(mu)
        prior = self._prior(batch.observation, (batch.prior_mu, batch.prior_log_sigma))
        kl = self._divergence(z, (mu, log_sigma), prior).mean()
        q = self._values(self.critics, batch.observation, z).amin(0)
        self.policy_adam.zero_grad()
        (alpha * kl - q.mean()).backward()
        self.policy_adam.step()
        self.alpha_adam.zero_grad()
        (self.log_alpha * (self.params.target_divergence - kl.detach())).backward()
        self.alpha_adam.step()
        with torch.no_grad():
            pairs = zip(self.target.parameters(), self.critics.parameters(), strict=True)
            for target, critic in pairs:
                target.mul_(1 - self.params.tau).add_(critic, alpha=self.params.tau)


def updates(learner: PlainLearner | Learner, replay: Replay, batch: int) -> Callable[[], None]:
    generator = torch.Generator().manual_seed(1)

    def run() -> None:
        for _ in range(ROUND):
            learner.update(replay.sample(batch, generator))

    return run


def variants(params: TransferParams) -> dict[str, Callable[[], None]]:
    """The learners to compare, from plain to ours, each with its replay buffer."""
    torch.manual_seed(0)
    names = [f"x{i}_pos" for i in range(OBSERVATION)]
    artifacts = Artifacts(
        SkillPrior(names, LATENT, 128, 6),
        Generator(LATENT, 128, 3),
        SkillVAE(10, 7, LATENT, 128),
    )
    start = method("lfr")(artifacts, params)
    replay = Replay(5000, OBSERVATION, LATENT)
    observation, after = torch.randn(2, 5000, OBSERVATION)
    with torch.no_grad():
        prior, next_prior = start.actor.prior(observation), start.actor.prior(after)
    z, reward = torch.randn(5000, LATENT), torch.rand(5000)
    discount = torch.full((5000,), params.gamma)
    replay.add(Batch(observation, z, reward, discount, after, *prior, *next_prior))

    def ours(policy_every: int) -> Learner:
        chosen = dataclasses.replace(params, policy_every=policy_every)
        begun, generator = method("lfr")(artifacts, chosen), torch.Generator().manual_seed(0)
        return Learner(begun.actor.policy, begun.normalizer, OBSERVATION, LATENT, chosen, generator)

    def plain(closed_form: bool, cached_prior: bool) -> PlainLearner:
        begun = method("lfr")(artifacts, params)
        return PlainLearner(begun, params, closed_form=closed_form, cached_prior=cached_prior)

    learners = {
        "plain": plain(False, False),
        "closed-form divergence": plain(True, False),
        "stored prior": plain(True, True),
        "batched critics, flat Adam and Polyak": ours(1),
        "policy every second update": ours(2),
    }
    return {name: updates(learner, replay, params.batch) for name, learner in learners.items()}


def measure(params: TransferParams, rounds: int) -> dict[str, list[float]]:
    """Updates per second of each variant, one figure a round, the rounds alternating."""
    chosen = variants(params)
    for run in chosen.values():
        run()
    rates: dict[str, list[float]] = {name: [] for name in chosen}
    for _ in range(rounds):
        for name, run in chosen.items():
            began = time.process_time()
            run()
            rates[name].append(ROUND / (time.process_time() - began))
    return rates


def rows(rates: dict[str, list[float]]) -> list[dict[str, object]]:
    base = rates["plain"]
    found = []
    for name, values in rates.items():
        ratios = sorted(a / b for a, b in zip(values, base, strict=True))
        found.append(
            {
                "name": name,
                "updates_per_second": statistics.median(values),
                "plain_updates_per_second": statistics.median(base),
                "ratio": statistics.median(ratios),
                "spread": [ratios[0], ratios[-1]],
                "goal_updates_per_second": GOAL_RATE,
            }
        )
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--batch", type=int, default=TransferParams().batch)
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/learner.json"))
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    params = dataclasses.replace(TransferParams(), batch=arguments.batch)
    table = rows(measure(params, arguments.rounds))
    load = os.getloadavg()[0]
    for row in table:
        rate, ratio = row["updates_per_second"], row["ratio"]
        print(f"{row['name']:40s} {rate:7.0f} updates/s  {ratio:5.2f} x plain")
    content = {"rows": table, "params": params, "load_average": load, "made_with": provenance()}
    write_json(arguments.out, content)


if __name__ == "__main__":
    main()
