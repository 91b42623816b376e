"""Stable-Baselines3's SAC on the networks of a transfer run; nothing else of it is changed."""

from __future__ import annotations

import itertools
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.transfer.critic import OBSERVATION_CLIP
from lfr.transfer.methods.initialization import Initialization
from lfr.transfer.transfer_params import TransferParams

try:
    from stable_baselines3 import SAC
    from stable_baselines3.common.logger import configure
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from stable_baselines3.sac.policies import Actor, ContinuousCritic, SACPolicy
except ImportError:
    raise SystemExit("this benchmark needs Stable-Baselines3: `make bench` brings it") from None


class Extractor(BaseFeaturesExtractor):
    """The prior's normalisation."""

    def __init__(self, space: Box, normalizer: nn.Module) -> None:
        super().__init__(space, normalizer(torch.zeros(1, *space.shape)).shape[-1])
        self.normalizer = normalizer

    def forward(self, observations: Tensor) -> Tensor:
        return self.normalizer(observations).clamp(-OBSERVATION_CLIP, OBSERVATION_CLIP)


def soft_actor_critic(
    initialization: Initialization, dimensions: int, params: TransferParams, rows: int
) -> SAC:
    """A SAC whose actor and critics have the run's networks, its replay buffer full of noise."""

    class MappedActor(Actor):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self.mu = self.log_std = nn.Identity()  # type: ignore[assignment]
            self.latent_pi = initialization.actor.policy.pi.network
            self.phi = initialization.actor.policy.phi

        def get_action_dist_params(self, obs: Any) -> tuple[Tensor, Tensor, dict[str, Tensor]]:
            features = self.extract_features(obs, self.features_extractor)
            mu, log_sigma = self.latent_pi(features).chunk(2, dim=-1)
            return (*self.phi(mu, log_sigma.clamp(*LOG_SIGMA_RANGE)), {})

    class NormalisedCritic(ContinuousCritic):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            first = next(self.q_networks[0].parameters()).shape[1]
            for i in range(len(self.q_networks)):
                self.q_networks[i] = critic_network(first, params)
                setattr(self, f"qf{i}", self.q_networks[i])

    class Policy(SACPolicy):
        def make_actor(self, features_extractor: Any = None) -> Actor:
            return MappedActor(
                **self._update_features_extractor(self.actor_kwargs, features_extractor)
            ).to(self.device)

        def make_critic(self, features_extractor: Any = None) -> ContinuousCritic:
            return NormalisedCritic(
                **self._update_features_extractor(self.critic_kwargs, features_extractor)
            ).to(self.device)

    model = SAC(
        Policy, Nothing(dimensions, initialization.latent_dim), learning_rate=params.critic_lr,
        buffer_size=rows, batch_size=params.batch, tau=params.tau, gamma=params.gamma, device="cpu",
        policy_kwargs={
            "net_arch": {"pi": [], "qf": list(params.critic_hidden)},
            "n_critics": params.critics,
            "features_extractor_class": Extractor,
            "features_extractor_kwargs": {"normalizer": initialization.normalizer},
        },
    )  # fmt: skip
    model.set_logger(configure(None, []))
    fill(model.replay_buffer)
    return model


def critic_network(inputs: int, params: TransferParams) -> nn.Sequential:
    layers: list[nn.Module] = []
    for inside, outside in itertools.pairwise([inputs, *params.critic_hidden]):
        layers.append(nn.Linear(inside, outside))
        layers += [nn.LayerNorm(outside)] if params.layer_norm else []
        layers.append(nn.ReLU())
    return nn.Sequential(*layers, nn.Linear(params.critic_hidden[-1], 1))


def fill(buffer: Any) -> None:
    random = np.random.default_rng(0)
    buffer.observations[:] = random.normal(size=buffer.observations.shape)
    buffer.next_observations[:] = random.normal(size=buffer.next_observations.shape)
    buffer.actions[:] = random.uniform(-1, 1, size=buffer.actions.shape)
    buffer.rewards[:] = random.uniform(size=buffer.rewards.shape)
    buffer.pos, buffer.full = 0, True


class Nothing(gymnasium.Env):
    """The spaces that SAC asks for."""

    def __init__(self, dimensions: int, latent_dim: int) -> None:
        self.observation_space = Box(-np.inf, np.inf, (dimensions,), np.float32)
        self.action_space = Box(-1.0, 1.0, (latent_dim,), np.float32)
