"""The policy pi' = phi o pi (Eq. 7) while it learns, its gradient written out."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from lfr.errors import LfrError
from lfr.mapping.generator import Generator
from lfr.networks.ensemble import Trace
from lfr.networks.perceptron import perceptrons
from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.skills.prior import SkillPrior
from lfr.transfer.extended_policy import MappedPolicy


class PolicyTrace(NamedTuple):
    """What the gradient needs of one evaluation of the policy.

    Attributes:
        within: 1 where k (B, 2Z) is within its bounds and 0 where it is held at one, of pi's k and
            of phi's.
        widening: d log_sigma / d log_sigma without ``min_sigma``, (B, Z); None where that is 0.
    """

    pi: list[Trace]
    phi: list[Trace]
    within: list[Tensor]
    widening: Tensor | None


class LearningPolicy:
    """A policy's (mu, log_sigma) and their gradient by its parameters, with k = [mu, log sigma]:

        k_pi = bounded(pi(s)),  k = bounded(phi(k_pi, s)),
        log_sigma = 1/2 log(sigma_k^2 + min_sigma^2)

    Its networks' parameters become views of one vector, in place: what learns is the policy itself.
    It answers as the policy does, which autograd would differentiate to the same numbers.

    Args:
        policy: pi is a `SkillPrior`; phi learns too if its parameters require a gradient.

    Attributes:
        vector: what learns, (P,); a change in place is a change of the policy.

    Raises:
        LfrError: pi is another network.
    """

    def __init__(self, policy: MappedPolicy) -> None:
        pi, phi, self.min_sigma = policy.pi, policy.phi, policy.min_sigma
        if not isinstance(pi, SkillPrior):
            raise LfrError(f"found a policy of {type(pi).__name__}, expected a SkillPrior to learn")
        self.features = policy.features
        self.phi = phi if isinstance(phi, Generator) else None
        self.phi_learns = self.phi is not None and any(p.requires_grad for p in phi.parameters())
        networks = [pi.network] if self.phi is None else [pi.network, self.phi.network]
        vector, gradient, (self._pi, *self._phi) = perceptrons(networks)
        learns = networks if self.phi_learns else networks[:1]
        size = sum(p.numel() for network in learns for p in network.parameters())
        self.vector, self._gradient = vector[:size], gradient[:size]
        low, high = LOG_SIGMA_RANGE
        unbounded = torch.full((pi.latent_dim,), math.inf).to(vector)
        self._bounds = (
            torch.cat([-unbounded, torch.full_like(unbounded, low)]),
            torch.cat([unbounded, torch.full_like(unbounded, high)]),
        )

    def evaluate(self, features: Tensor) -> tuple[Tensor, Tensor, PolicyTrace]:
        """(mu, log_sigma), (B, Z) each, for the policy's `features`, and how they came about."""
        of_pi, of_phi, within, widening = [], [], [], None
        beside = 0 if self.phi is None else self.phi.feature_size
        seen, seen_by_phi = features.split([features.shape[-1] - beside, beside], dim=-1)
        k, of_pi = self._pi.evaluate(seen)
        k = self._bounded(k, within)
        if self.phi is not None:
            y, of_phi = self._phi[0].evaluate(self.phi.inputs(k, seen_by_phi))  # Eq. 7
            k = self._bounded(self.phi.read(y), within)
        mu, log_sigma = k.chunk(2, dim=-1)
        if self.min_sigma > 0.0:
            bound = torch.full_like(log_sigma, 2.0 * math.log(self.min_sigma))
            wide = 0.5 * torch.logaddexp(2.0 * log_sigma, bound)
            log_sigma, widening = wide, torch.exp(2.0 * (log_sigma - wide))
        return mu, log_sigma, PolicyTrace(of_pi, of_phi, within, widening)

    def by_parameters(self, trace: PolicyTrace, by_mu: Tensor, by_log_sigma: Tensor) -> Tensor:
        """dL/dvector (P,) for dL/dmu and dL/dlog_sigma (B, Z); overwritten by the next call."""
        if trace.widening is not None:
            by_log_sigma = by_log_sigma * trace.widening
        by_k = torch.cat([by_mu, by_log_sigma], dim=-1).mul_(trace.within[-1])
        if self.phi is not None:
            by_x = self._phi[0].differentiate(
                trace.phi, by_k * self.phi.scale_out, learns=self.phi_learns, by_x=True
            )
            assert by_x is not None
            by_k = by_x[:, : by_k.shape[1]] / self.phi.scale_in * trace.within[0]
        self._pi.differentiate(trace.pi, by_k)
        return self._gradient

    def _bounded(self, k: Tensor, within: list[Tensor]) -> Tensor:
        bounded = torch.clamp(k, *self._bounds)
        within.append(bounded == k)  # as autograd has it: nothing passes a bound
        return bounded
