"""Acting by skills on the target arm: a policy chooses z, the arm's own decoder executes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from lfr.transfer.distribution import GAUSSIAN, Distribution
from lfr.transfer.extended_policy import MappedPolicy


class Decoder(Protocol):
    """What turns skills into actions: a skill VAE, or `OneAction`."""

    @property
    def latent_dim(self) -> int: ...

    def to(self, device: torch.device, /) -> object:
        """Move its parameters, in place."""
        ...

    def carry_out(self, z: Tensor, observations: Tensor, /) -> Sequence[Tensor]:
        """Actions (n, A) in [-1, 1] of each skill of (B, Z) that begin at observations (B, D)."""
        ...


class OneAction(nn.Module):
    """The decoder of a method without skills: z is the next control step's action itself."""

    def __init__(self, latent_dim: int) -> None:
        super().__init__()
        self.latent_dim = latent_dim

    def carry_out(self, z: Tensor, observations: Tensor) -> Sequence[Tensor]:
        return list(z.clamp(-1.0, 1.0)[:, None, :])


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
        distribution: how the policy's (mu, log_sigma) become a skill.
    """

    policy: MappedPolicy
    prior: MappedPolicy
    decoder: Decoder
    distribution: Distribution = GAUSSIAN

    def to(self, device: torch.device) -> SkillActor:
        """Move all of its networks, in place."""
        for network in (self.policy, self.prior, self.decoder):
            network.to(device)
        return self

    @property
    def device(self) -> torch.device:
        """Where the policy's parameters are."""
        return next(self.policy.parameters()).device

    def reset(self, seed: int) -> None:
        """Nothing is remembered; what `act` does is not drawn."""

    @torch.no_grad()
    def choose(self, observations: Tensor, generator: torch.Generator | None = None) -> Choice:
        """Skills for observations (B, D): a sample with a generator, the mean without."""
        mu, log_sigma = self.policy(observations)
        noise = None
        if generator is not None:
            noise = torch.randn(mu.shape, generator=generator).to(mu.device)
        return Choice(self.distribution.skill(mu, log_sigma, noise), mu, log_sigma)

    @torch.no_grad()
    def decode(self, z: Tensor, observations: Tensor) -> list[NDArray[np.float64]]:
        """Actions (n, A) in [-1, 1] of each of the skills (B, Z), as many as are carried out.

        Args:
            observations: (B, D), where the skills begin.
        """
        carried_out = self.decoder.carry_out(z, observations)
        return [skill.cpu().double().numpy() for skill in carried_out]

    def act(self, observation: NDArray[np.floating]) -> NDArray[np.float64]:
        """The next skill's actions (n, A) for an observation (D,)."""
        return self.act_all(observation[None])[0]

    def act_all(self, observations: NDArray[np.floating]) -> list[NDArray[np.float64]]:
        """The next skills' actions, (n, A) for each of the observations (B, D).

        The means of the policy, not samples.
        """
        rows = as_tensor(observations).to(self.device)
        return self.decode(self.choose(rows).z, rows)


def as_tensor(observations: NDArray[np.floating]) -> Tensor:
    """Observations (B, D) as the networks take them, float32."""
    return torch.from_numpy(np.asarray(observations, dtype=np.float32))
