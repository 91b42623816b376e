"""Algorithm 1: G and F trained on the skill distributions that both arms predict for a state."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import torch
from torch import Tensor, nn

from lfr.mapping.generator import Generator
from lfr.mapping.losses import mapping_loss
from lfr.skills.augmentation import augment
from lfr.skills.prior import SkillPrior
from lfr.skills.rows import thinned
from lfr.skills.symmetry import SymmetryParams, moved_states
from lfr.skills.vae import CHUNK, SkillVAE


@dataclass(frozen=True)
class MappingParams:
    """Parameters of the mapping stage: section ``mapping`` of params.yaml."""

    hidden: int = 128
    layers: int = 3  # part V.A
    cycle_weight: float = 1.0  # lambda of Eq. 4
    steps: int = 4000
    batch: int = 256
    learning_rate: float = 1e-3
    symmetry: SymmetryParams = field(default_factory=SymmetryParams)  # of the states compared
    state_noise: float = 0.1  # of an input's normalised unit: states between and beside the demos
    posterior_share: float = 0.5  # share of pairs that are both encoders' posteriors of one window


@dataclass(frozen=True)
class CommonTask:
    """One task that both arms know: their priors for it and the states to compare them in.

    Attributes:
        prior_x: the source's prior.
        prior_y: the target's prior.
        observations: (N, D), states of both arms' demonstrations.
    """

    prior_x: SkillPrior
    prior_y: SkillPrior
    observations: Tensor


class ActionWindows(NamedTuple):
    """Actions (N, H, A) in [-1, 1], their dimensions called ``names``."""

    actions: Tensor
    names: tuple[str, ...]


@torch.no_grad()
def paired(task: CommonTask, observations: Tensor) -> tuple[Tensor, Tensor]:
    """k_x and k_y (B, 2Z): what either arm would do in the same states (lines 5 to 7)."""
    k_x, k_y = (
        torch.cat([torch.cat(prior(some), dim=-1) for some in observations.split(CHUNK)])
        for prior in (task.prior_x, task.prior_y)
    )
    return k_x, k_y


def train_mapping(
    tasks: list[CommonTask],
    encoders: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows | None,
    params: MappingParams,
    seed: int,
) -> tuple[Generator, Generator]:
    """G: X -> Y and F: Y -> X, by Algorithm 1.

    Algorithm 1 draws a common task and a state in each iteration, predicts both arms'
    distributions, maps them and descends on Eq. 4. Lines 9 and 10 map one way only, depending on
    whose state it is; here every pair trains both ways, which are the same two terms of Eq. 5.

    Args:
        tasks: the common tasks; each is drawn equally often.
        encoders: the source's and the target's skill VAE.
        windows: of the common tasks by both arms, used if ``posterior_share`` > 0; None else, as
            where the two arms' actions are different things.
    """
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    latent_dim = tasks[0].prior_x.latent_dim
    g = Generator(latent_dim, params.hidden, params.layers)
    f = Generator(latent_dim, params.hidden, params.layers)
    tasks = [
        replace(
            task,
            observations=moved_states(
                task.observations, task.prior_x.layout_names, params.symmetry, generator
            ),
        )
        for task in tasks
    ]
    known = [paired(task, thinned(task.observations)) for task in tasks]
    k_x = torch.cat([pair[0] for pair in known])
    k_y = torch.cat([pair[1] for pair in known])
    g.fit_scales(k_x, k_y)
    f.fit_scales(k_y, k_x)
    weights = [*g.network.parameters(), *f.network.parameters()]
    optimizer = torch.optim.Adam(weights, params.learning_rate, fused=True)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, max(params.steps, 1))
    posteriors = 0 if windows is None else round(params.posterior_share * params.batch)
    per_task = (params.batch - posteriors) // len(tasks)
    for _ in range(params.steps):
        pairs = [_sample(task, per_task, params.state_noise, generator) for task in tasks]
        if posteriors and windows is not None:
            pairs.append(_posteriors(encoders, windows, posteriors, generator))
        k_x = torch.cat([pair[0] for pair in pairs])
        k_y = torch.cat([pair[1] for pair in pairs])
        loss = mapping_loss(g, f, k_x, k_y, params.cycle_weight)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(weights, 50.0, foreach=True)
        optimizer.step()
        schedule.step()
    return g.eval(), f.eval()


def _sample(
    task: CommonTask, count: int, noise: float, generator: torch.Generator
) -> tuple[Tensor, Tensor]:
    """Pairs at ``count`` states drawn from the task's, blurred."""
    index = torch.randint(len(task.observations), (count,), generator=generator)
    observations = task.observations[index]
    blur = noise * task.prior_x.normalizer.noise_scale()
    observations = observations + blur * torch.randn(observations.shape, generator=generator)
    return paired(task, observations)


@torch.no_grad()
def _posteriors(
    encoders: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows,
    count: int,
    generator: torch.Generator,
) -> tuple[Tensor, Tensor]:
    """What both encoders make of the same, augmented windows: pairs beyond the common tasks."""
    index = torch.randint(len(windows.actions), (count,), generator=generator)
    actions = augment(windows.actions[index], windows.names, generator)
    k_x, k_y = (torch.cat(encoder.encode(actions), dim=-1) for encoder in encoders)
    return k_x, k_y
