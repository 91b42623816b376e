"""Small recurrent policies, and demonstrations that are random numbers."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from lfr.columns import ActionSpace
from lfr.data.windows import DemonstrationSet
from studies.imitation.imitation_params import ImitationParams
from studies.imitation.recurrent_gmm import RecurrentGMM

NAMES = ("eef_pos.x", "eef_pos.y", "eef_to_cube.z")
SMALL = ImitationParams(
    hidden=16, layers=2, horizon=4, modes=2, batch=32, updates=5, learning_rate=1e-2
)


def network(seed: int = 0) -> RecurrentGMM:
    torch.manual_seed(seed)
    return RecurrentGMM(NAMES, 2, 16, 2, 3, 1e-4, 10).eval()


def demonstrations(lengths: Sequence[int], seed: int = 0) -> DemonstrationSet:
    """Episodes of these lengths; the actions (N, 2) are the first two of the inputs (N, 3)."""
    generator = torch.Generator().manual_seed(seed)
    observations = 0.9 * (2.0 * torch.rand(sum(lengths), 3, generator=generator) - 1.0)
    starts = torch.tensor([0, *lengths]).cumsum(0)
    space = ActionSpace(("x", "y"), (-1.0, -1.0), (1.0, 1.0))
    return DemonstrationSet(
        observations, observations[:, :2].clone(), None, None, starts, NAMES, space,
        "panda", "lift", 20,
    )  # fmt: skip
