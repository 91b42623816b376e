"""A policy that begins as another task's prior and sees what that task has not: a goal, a yaw."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lfr.model_files import ModelKind
from lfr.skills.normalizer import Normalizer
from lfr.skills.prior import SkillPrior
from studies.spirl.other_task import OTHER_TASK, OtherTaskPrior, in_places, places_of


class ResidualPriorPolicy(SkillPrior):
    """A skill prior that sees what the inner prior is asked about, and all of D beside it.

    What the inner prior is not asked about has weights in the first layer that begin at zero:
    before it learns, the policy answers as the prior does.
    """

    places: Tensor

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
        super().__init__(layout_names, latent_dim, hidden, layers, turned)
        self.inner_names, self.columns = tuple(inner_names), tuple(columns)
        self.inner_normalizer = Normalizer(self.inner_names, turned=turned)
        places = places_of(self.columns, len(self.layout_names))
        self.register_buffer("places", places, persistent=False)
        self.network[0] = nn.Linear(self.inner_normalizer.size + self.normalizer.size, hidden)

    def features(self, observations: Tensor) -> Tensor:
        """What the inner prior sees of observations (B, D), then all of them: (B, inputs)."""
        asked = in_places(observations, self.inner_normalizer.mean, self.places)
        return torch.cat([self.inner_normalizer(asked), self.normalizer(observations)], dim=-1)


RESIDUAL_PRIOR = ModelKind("residual_prior_policy", ResidualPriorPolicy, OTHER_TASK.shape)


@torch.no_grad()
def residual_prior(prior: OtherTaskPrior, reference: SkillPrior) -> ResidualPriorPolicy:
    """A policy that begins as ``prior``; it sees the rest in the units of ``reference``."""
    shape = (prior.layout_names, prior.inner_names, prior.columns, prior.latent_dim)
    policy = ResidualPriorPolicy(*shape, prior.hidden, prior.layers, reference.turned)
    policy.normalizer.load_state_dict(reference.normalizer.state_dict())
    policy.inner_normalizer.load_state_dict(prior.inner.normalizer.state_dict())
    weights = prior.inner.network.state_dict()
    first = weights["0.weight"]
    beside = first.new_zeros(len(first), policy.normalizer.size)
    policy.network.load_state_dict(weights | {"0.weight": torch.cat([first, beside], dim=-1)})
    return policy
