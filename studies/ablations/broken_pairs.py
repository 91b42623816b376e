"""Algorithm 1 on pairs that are none: k_x of one state or window beside k_y of any other."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import torch
from torch import Tensor

from lfr.mapping.generator import Generator
from lfr.mapping.mapping_training import ActionWindows, CommonTask, MappingParams, train_mapping
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE


class Unrelated:
    """A prior or encoder that answers each row with one of the answers that some row got.

    The answers keep their distribution, over all tasks and windows together; which row got which
    is lost, its task too.
    """

    def __init__(self, answers: Tensor, seed: int) -> None:
        """Args: answers: k (N, 2Z)."""
        self.answers = answers
        self.generator = torch.Generator().manual_seed(seed)

    def __call__(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        index = torch.randint(len(self.answers), (len(rows),), generator=self.generator)
        mu, log_sigma = self.answers[index].chunk(2, dim=-1)
        return mu, log_sigma

    encode = __call__


def shuffled(
    tasks: list[CommonTask],
    encoders: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows | None,
    answers: Tensor,
    params: MappingParams,
    seed: int,
) -> Generator:
    """G as `train_mapping` learns it where the pairs carry no information.

    Args:
        answers: k_y (N, 2Z) of the true pairs (`studies.ablations.closed_form.pairs_of`).
    """
    unrelated = Unrelated(answers, seed)
    broken = [replace(task, prior_y=cast(SkillPrior, unrelated)) for task in tasks]
    pair = encoders[0], cast(SkillVAE, unrelated)
    return train_mapping(broken, pair, windows, params, seed)[0]
