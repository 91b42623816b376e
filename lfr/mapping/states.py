"""States in which two arms' skills are compared."""

from __future__ import annotations

import torch
from torch import Tensor

from lfr.mapping.mapping_params import MappingParams
from lfr.skills.prior import SkillPrior
from lfr.skills.symmetry import moved_states


def drawn_states(
    prior: SkillPrior,
    observations: Tensor,
    count: int,
    params: MappingParams,
    generator: torch.Generator,
) -> Tensor:
    """``count`` states (count, D) drawn from observations (N, D) and their moved copies, blurred.

    Args:
        prior: that of the task, whose layout and units they have.
    """
    states = moved_states(observations, prior.layout_names, params.symmetry, generator)
    states = states[torch.randint(len(states), (count,), generator=generator)]
    blur = params.state_noise * prior.normalizer.noise_scale()
    return states + blur * torch.randn(states.shape, generator=generator)
