"""Critics Q(s, z) over observations and skills, and what they are taught."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lfr.networks.ensemble import Shape, Trace, differentiate, evaluate

# A state further out than this was never near the demonstrations; a larger input would only make
# the critics extrapolate.
OBSERVATION_CLIP = 10.0


class CriticEnsemble:
    """Q_e(s, z) for e = 1..E: observations (B, D) and skills (B, Z) to values (E, B).

    Not differentiable by autograd: ``by_parameters`` and ``by_skill`` are its gradients.

    Attributes:
        normalizer: maps raw observations to unit scale; it has no trainable parameters.
        vector: all parameters (P,); a change in place is a change of the critics.
    """

    def __init__(
        self,
        normalizer: nn.Module,
        observation_dim: int,
        latent_dim: int,
        ensemble: int,
        hidden: Sequence[int],
        *,
        layer_norm: bool,
    ) -> None:
        self.normalizer, self.latent_dim = normalizer, latent_dim
        self.shape = Shape(ensemble, (observation_dim + latent_dim, *hidden), layer_norm)
        self._hold(self.shape.initial())

    def _hold(self, vector: Tensor) -> None:
        self.vector, self.gradient = vector, torch.zeros_like(vector)
        self.layers, self.slopes = self.shape.layers(vector), self.shape.layers(self.gradient)

    def to(self, device: torch.device) -> CriticEnsemble:
        """Move all of it, in place."""
        self.normalizer.to(device)
        self._hold(self.vector.to(device))
        return self

    def clone(self) -> CriticEnsemble:
        """Critics of their own with the same parameters."""
        other = copy.copy(self)
        other._hold(self.vector.clone())
        return other

    def inputs(self, observation: Tensor) -> Tensor:
        """The normalised observations (B, D) that several calls of ``values`` can share."""
        return self.normalizer(observation).clamp_(-OBSERVATION_CLIP, OBSERVATION_CLIP)

    def values(self, inputs: Tensor, z: Tensor) -> tuple[Tensor, list[Trace]]:
        """Q (E, B) at normalised observations (B, D) and skills (B, Z), and how it came about."""
        x = torch.cat([inputs, z], dim=-1).expand(self.shape.ensemble, -1, -1)
        q, traces = evaluate(self.layers, x)
        return q.squeeze(-1), traces

    def by_parameters(self, traces: list[Trace], slope: Tensor) -> Tensor:
        """dL/dparameters (P,) for dL/dQ (E, B); overwritten by the next call."""
        differentiate(self.layers, traces, slope[..., None], into=self.slopes)
        return self.gradient

    def by_skill(self, traces: list[Trace], slope: Tensor) -> Tensor:
        """dL/dz (B, Z) for dL/dQ (E, B)."""
        gradient = differentiate(self.layers, traces, slope[..., None], by_inputs=True)
        assert gradient is not None
        return gradient[:, :, -self.latent_dim :].sum(0)


def pessimistic(q: Tensor, members: Tensor | None = None) -> Tensor:
    """Double-Q: the minimum (B,) over the ensemble's values (E, B), or over some of its members."""
    return (q if members is None else q[members]).amin(0)


def td_target(
    reward: Tensor, discount: Tensor, next_q: Tensor, alpha: Tensor, kl: Tensor
) -> Tensor:
    """y = r + discount (Q(s', z') - alpha KL(pi'(.|s') || phi(p_a(.|s')))), (B,).

    Eq. 9 in place of SAC's entropy. ``discount`` is gamma, or 0 after a terminal state; a time
    limit is none, so it bootstraps. Time is counted in skills, not in control steps.
    """
    return torch.addcmul(reward, discount, next_q - alpha * kl)


def critic_loss(q: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
    """Squared TD error of (E, B) values against (B,) targets: mean over B, summed over E.

    Returns:
        The loss and its gradient by q, (E, B).
    """
    error = q - target
    slope = error * (2.0 / q.shape[1])
    return 0.5 * (error * slope).sum(), slope
