"""A task that is one line of arithmetic, and the artifacts and parameters of a run on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch

from lfr.mapping.generator import Generator
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.methods.initialization import Initialization, initialize_from
from lfr.transfer.transfer_params import TransferParams

NAMES = ("x_pos", "goal_pos", "goal_to_x")


@dataclass(frozen=True)
class FakeSteps:
    observations: np.ndarray
    rewards: np.ndarray
    successes: np.ndarray
    diverged: bool


class PointSimulation:
    """A point moves along a line by half of each action's first entry; success within 0.25."""

    def __init__(self, horizon: int = 8, diverge_at: int | None = None) -> None:
        self.horizon, self.diverge_at = horizon, diverge_at
        self.x, self.goal, self.resets = 0.0, 1.0, 0

    def reset(self, seed: int) -> np.ndarray:
        self.resets += 1
        self.x, self.goal = 0.0, float(np.random.default_rng(seed).choice([-1.0, 1.0]))
        return self.observation()

    def observation(self) -> np.ndarray:
        return np.array([self.x, self.goal, self.goal - self.x])

    def step(self, actions: np.ndarray, stop_on_success: bool = False) -> FakeSteps:
        observations, rewards, successes = [], [], []
        for i, action in enumerate(actions):
            self.x += 0.5 * float(action[0])
            distance = abs(self.goal - self.x)
            observations.append(self.observation())
            rewards.append(max(0.0, 1.0 - distance))
            successes.append(distance < 0.25)
            if self.diverge_at == i:
                break
            if stop_on_success and successes[-1]:
                break
        return FakeSteps(
            np.array(observations),
            np.array(rewards),
            np.array(successes, dtype=bool),
            self.diverge_at is not None,
        )

    def state(self) -> np.ndarray:
        return np.array([self.x, self.goal])

    def set_state(self, state: np.ndarray) -> None:
        self.x, self.goal = float(state[0]), float(state[1])


class DirectDecoder(SkillVAE):
    """Every action of the skill is tanh(z): what the point does is what was chosen."""

    def reconstruct(
        self, z: torch.Tensor, observations: torch.Tensor | None = None, steps: int | None = None
    ) -> torch.Tensor:
        return torch.tanh(z)[:, None, :].expand(-1, steps or self.horizon, -1)


class Models(NamedTuple):
    source_prior: SkillPrior
    generator: Generator
    target_vae: SkillVAE


def lfr_initialization(models: Models, params: TransferParams) -> Initialization:
    """Where Learn from Robot starts, from models that are in no folder."""
    prior, phi, decoder = models
    return initialize_from(prior, phi, decoder, params, prior)


def point_models() -> Models:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        return Models(
            source_prior=SkillPrior(NAMES, latent_dim=2, hidden=16, layers=2),
            generator=Generator(latent_dim=2, hidden=16, layers=3),
            target_vae=DirectDecoder(horizon=3, action_dim=2, latent_dim=2, hidden=8),
        )


def point_params() -> TransferParams:
    return TransferParams(
        steps=120,
        batch=16,
        warm_up=20,
        replay=64,
        critic_hidden=(16, 16),
        simulations=2,
        evaluate_every=60,
        evaluation_episodes=3,
        checkpoint_every=30,
        updates_per_skill=1.5,
    )
