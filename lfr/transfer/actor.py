"""Acting by skills on the target arm: a policy chooses z, the arm's own decoder executes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from lfr.skills.vae import SkillVAE
from lfr.transfer.policy import MappedPolicy


class Choice(NamedTuple):
    """The skills chosen for B observations: z and the distribution it comes from, (B, Z) each."""

    z: Tensor
    mu: Tensor
    log_sigma: Tensor


@dataclass(frozen=True)
class SkillActor:
    """A policy over skills with the decoder that turns them into actions.

    Attributes:
        policy: pi' (Eq. 7).
        prior: the frozen phi(p_a) of Eq. 9, kept to show how far the policy moved from it.
        decoder: the target arm's skill VAE, frozen.
    """

    policy: MappedPolicy
    prior: MappedPolicy
    decoder: SkillVAE

    @torch.no_grad()
    def choose(self, observations: Tensor, generator: torch.Generator | None = None) -> Choice:
        """Skills for observations (B, D): a sample with a generator, the mean without."""
        mu, log_sigma = self.policy(observations)
        if generator is None:
            return Choice(mu, mu, log_sigma)
        epsilon = torch.randn(mu.shape, generator=generator)
        return Choice(mu + log_sigma.exp() * epsilon, mu, log_sigma)

    @torch.no_grad()
    def decode(self, z: Tensor) -> NDArray[np.float64]:
        """Actions (B, n, A) in [-1, 1] of skills (B, Z), as many as the decoder carries out."""
        return self.decoder.carry_out(z).double().numpy()

    def act(self, observation: NDArray[np.floating]) -> NDArray[np.float64]:
        """The next skill's actions (n, A) for an observation (D,), or (B, n, A) for (B, D).

        The mean of the policy, not a sample.
        """
        rows = np.atleast_2d(observation)
        actions = self.decode(self.choose(as_tensor(rows)).z)
        return actions if np.ndim(observation) > 1 else actions[0]


def as_tensor(observations: NDArray[np.floating]) -> Tensor:
    """Observations (B, D) as the networks take them, float32."""
    return torch.from_numpy(np.asarray(observations, dtype=np.float32))
