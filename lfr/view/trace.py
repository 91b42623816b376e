"""The skills of a policy's episode, and the distributions that they were drawn from."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SkillTrace:
    """The K skills of an episode and the Gaussians they were drawn from; Z latent dimensions.

    Attributes:
        skill_start: (K,) frame at which each skill begins, rising.
        z: (K, Z) the latent that was decoded.
        policy_mu, policy_log_sigma: (K, Z) of the policy pi', in the target's latent space.
        prior_mu, prior_log_sigma: (K, Z) of the source's prior p_a, in the source's.
        mapped_mu, mapped_log_sigma: (K, Z) of phi(p_a), in the target's.

    Raises:
        ValueError: shapes that do not agree.
    """

    skill_start: NDArray[np.int64]
    z: NDArray[np.floating]
    policy_mu: NDArray[np.floating]
    policy_log_sigma: NDArray[np.floating]
    prior_mu: NDArray[np.floating]
    prior_log_sigma: NDArray[np.floating]
    mapped_mu: NDArray[np.floating]
    mapped_log_sigma: NDArray[np.floating]

    def __post_init__(self) -> None:
        expected = (len(self.skill_start), self.latent_dim)
        for field in fields(self)[1:]:
            if (found := getattr(self, field.name).shape) != expected:
                raise ValueError(f"{field.name} has shape {found}, expected {expected}")

    @property
    def latent_dim(self) -> int:
        return self.z.shape[1]

    @property
    def divergence(self) -> NDArray[np.float64]:
        """(K,) KL(pi' || phi(p_a)) in nats, summed over the dimensions (Eq. 9)."""
        gap = (self.policy_mu - self.mapped_mu) ** 2
        ratio = (np.exp(2 * self.policy_log_sigma) + gap) / np.exp(2 * self.mapped_log_sigma)
        log_ratio = self.mapped_log_sigma - self.policy_log_sigma
        return np.sum(log_ratio + 0.5 * ratio - 0.5, axis=1)
