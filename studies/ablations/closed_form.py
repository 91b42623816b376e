"""Maps that need no descent: the best linear one, and the one that ignores what it is given."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from lfr.mapping.generator import Generator
from lfr.mapping.mapping_training import (
    ActionWindows,
    CommonTask,
    MappingParams,
    _posteriors,
    _sample,
)
from lfr.skills.symmetry import moved_states
from lfr.skills.vae import SkillVAE

PAIRS = 2**16  # some thousand for each of a linear map's rows
BATCH = 2**12


def pairs_of(
    tasks: list[CommonTask],
    encoders: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows | None,
    params: MappingParams,
    seed: int,
    count: int = PAIRS,
) -> tuple[Tensor, Tensor]:
    """k_x and k_y (N, 2Z), drawn as `lfr.mapping.mapping_training.train_mapping` draws its batches.

    Both arms' predictions at moved, blurred states, every task equally often, and in the same share
    as there both encoders' posteriors of the same augmented windows.

    Args:
        count: N is this or a little less.
    """
    generator = torch.Generator().manual_seed(seed)
    posteriors = round(params.posterior_share * BATCH) if windows is not None else 0
    per_task = (BATCH - posteriors) // len(tasks)
    pairs = []
    for task in tasks:
        states = moved_states(
            task.observations, task.prior_x.layout_names, params.symmetry, generator
        )
        moved = CommonTask(task.prior_x, task.prior_y, states)
        pairs += [
            _sample(moved, per_task, params.state_noise, generator) for _ in range(count // BATCH)
        ]
    if windows is not None and posteriors:
        pairs += [
            _posteriors(encoders, windows, posteriors, generator) for _ in range(count // BATCH)
        ]
    return torch.cat([pair[0] for pair in pairs]), torch.cat([pair[1] for pair in pairs])


@torch.no_grad()
def linear(k_x: Tensor, k_y: Tensor) -> Generator:
    """k_y = W k_x + b with the least squared error over pairs (N, 2Z), all dimensions alike."""
    g, layer = _one_layer(k_x)
    g.fit_scales(k_x, k_y)
    x = ((k_x - g.centre_in) / g.scale_in).double()
    y = ((k_y - g.centre_out) / g.scale_out).double()
    found = torch.linalg.lstsq(torch.cat([x, torch.ones(len(x), 1)], dim=-1), y).solution
    layer.weight.copy_(found[:-1].T)
    layer.bias.copy_(found[-1])
    return g.eval()


@torch.no_grad()
def constant(k_x: Tensor, k_y: Tensor) -> Generator:
    """The mean of k_y (N, 2Z), whatever comes: what G does without looking."""
    g, layer = _one_layer(k_x)
    g.fit_scales(k_x, k_y)
    layer.weight.zero_()
    layer.bias.zero_()
    return g.eval()


def _one_layer(k_x: Tensor) -> tuple[Generator, nn.Linear]:
    size = k_x.shape[-1]
    g = Generator(size // 2, hidden=size, layers=1)
    layer = g.network[-1]
    assert isinstance(layer, nn.Linear)
    return g, layer
