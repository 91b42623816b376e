"""A policy that begins as another task's prior and sees what that task has not: a goal, a yaw."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lfr.model_files import ModelKind
from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.skills.normalizer import Normalizer
from lfr.skills.prior import SkillPrior
from studies.spirl.other_task import OTHER_TASK, OtherTaskPrior


class ResidualPriorPolicy(nn.Module):
    """Observations (B, D) to (mu, log_sigma), (B, Z) each: a prior with all of D beside its inputs.

    What the prior is not asked about enters its first layer by weights of their own, which begin
    at zero: before it learns, the policy answers as the prior does.
    """

    def __init__(
        self,
        layout_names: Sequence[str],
        inner_names: Sequence[str],
        columns: Sequence[int],
        latent_dim: int,
        hidden: int,
        layers: int,
        turned: bool = False,
    ) -> None:
        super().__init__()
        self.prior = OtherTaskPrior(
            layout_names, inner_names, columns, latent_dim, hidden, layers, turned
        )  # fmt: skip
        self.layout_names, self.inner_names = self.prior.layout_names, self.prior.inner_names
        self.columns, self.latent_dim = self.prior.columns, latent_dim
        self.hidden, self.layers = hidden, layers
        self.turned = turned
        self.normalizer = Normalizer(self.layout_names, turned=turned)
        self.residual = nn.Linear(self.normalizer.size, hidden, bias=False)
        nn.init.zeros_(self.residual.weight)

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        first, *rest = self.prior.inner.network
        asked = self.prior.inner.normalizer(self.prior.asked(observations))
        x = first(asked) + self.residual(self.normalizer(observations))
        for layer in rest:
            x = layer(x)
        mu, log_sigma = x.chunk(2, dim=-1)
        return mu, log_sigma.clamp(*LOG_SIGMA_RANGE)


RESIDUAL_PRIOR = ModelKind("residual_prior_policy", ResidualPriorPolicy, OTHER_TASK.shape)


@torch.no_grad()
def residual_prior(prior: OtherTaskPrior, reference: SkillPrior) -> ResidualPriorPolicy:
    """A policy that begins as ``prior``; it sees the rest in the units of ``reference``."""
    shape = (prior.layout_names, prior.inner_names, prior.columns, prior.latent_dim)
    policy = ResidualPriorPolicy(*shape, prior.hidden, prior.layers, reference.turned)
    policy.prior.load_state_dict(prior.state_dict())
    policy.normalizer.load_state_dict(reference.normalizer.state_dict())
    return policy
