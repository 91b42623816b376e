"""How well G and F map states that nothing was trained on, of the common tasks and of the new one.

Eq. 5 and 6 are given as they are trained: sums over the 2Z numbers of a distribution. On a common
task both arms have a prior, so regression can be measured. On the new task the target has none
(the oracle's lies in another VAE's latent space, so its numbers mean nothing here), which leaves
what needs the source's prior alone: the cycle from X, and whether the target's decoder makes of
G(k_x) the actions that the source's decoder makes of k_x. The last is measured on both kinds of
task, so the two can be compared.
"""

from __future__ import annotations

import torch
from torch import Tensor

from lfr.mapping.generator import Generator
from lfr.mapping.mapping_training import CommonTask, paired
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import CHUNK, SkillVAE


@torch.no_grad()
def common_report(task: CommonTask, g: Generator, f: Generator) -> dict[str, float]:
    """Both terms of Eq. 5 and of Eq. 6 at a common task's states."""
    k_x, k_y, _ = paired(task, task.observations)
    seen = g.features(task.observations)  # F sees the same
    to_y, to_x = g.translate(k_x, seen), f.translate(k_y, seen)
    return {
        "regression_g": l1(to_y, k_y),
        "regression_f": l1(to_x, k_x),
        "cycle_x": l1(f.translate(to_y, seen), k_x),
        "cycle_y": l1(g.translate(to_x, seen), k_y),
        # What a mapping that ignores its input would reach: the scale of the two above.
        "spread_x": l1(k_x.median(0).values.expand_as(k_x), k_x),
        "spread_y": l1(k_y.median(0).values.expand_as(k_y), k_y),
    }


@torch.no_grad()
def new_task_report(
    prior_x: SkillPrior, observations: Tensor, g: Generator, f: Generator
) -> dict[str, float]:
    """The term of Eq. 6 that needs no prior of the target, at the new task's states (N, D)."""
    k_x, seen = torch.cat(prior_x(observations), dim=-1), g.features(observations)
    return {
        "cycle_x": l1(f.translate(g.translate(k_x, seen), seen), k_x),
        "spread_x": l1(k_x.median(0).values.expand_as(k_x), k_x),
    }


@torch.no_grad()
def decoded_difference(
    prior_x: SkillPrior, observations: Tensor, g: Generator, source: SkillVAE, target: SkillVAE
) -> Tensor:
    """Root-mean-square difference (A,), per action dimension, of the mean skill as either does it.

    Not an error in itself: the arms may have to move differently. On the common tasks both
    demonstrators' actions are much alike, so there it is mostly one.
    """
    squares = torch.zeros(source.action_dim, dtype=torch.float64)
    for some in observations.split(CHUNK):
        mu, log_sigma = prior_x(some)
        apart = source.decode(mu, some) - target.decode(g.at(mu, log_sigma, some)[0], some)
        squares += apart.square().sum(dim=(0, 1), dtype=torch.float64)
    return (squares / (len(observations) * source.horizon)).sqrt().float()


def l1(predicted: Tensor, expected: Tensor) -> float:
    """Mean over rows of the sum over columns of |predicted - expected|."""
    return float((predicted - expected).abs().sum(-1).mean())
