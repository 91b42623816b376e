"""Training of a skill VAE and of skill priors on windows of demonstrations (Eq. 2 and 3)."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lfr.skills.augmentation import augment
from lfr.skills.prior import SkillPrior, task_loss
from lfr.skills.skill_params import PriorParams, VAEParams
from lfr.skills.symmetry import moved_copies
from lfr.skills.vae import SkillVAE, vae_loss


def train_vae(actions: Tensor, names: Sequence[str], params: VAEParams, seed: int) -> SkillVAE:
    """A skill VAE of action windows (N, H, A) in [-1, 1], named ``names``, all tasks together.

    Every task counts alike only if its windows do: give it as many as it should weigh.
    """
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    vae = SkillVAE(
        params.horizon, actions.shape[-1], params.latent_dim, params.hidden, params.execute
    )
    optimizer = torch.optim.Adam(vae.parameters(), params.learning_rate, fused=True)
    schedule = _annealed(optimizer, params.steps)
    augmented = round(params.augment * params.batch)
    for _ in range(params.steps):
        batch = actions[torch.randint(len(actions), (params.batch,), generator=generator)]
        if augmented:
            batch = torch.cat([augment(batch[:augmented], names, generator), batch[augmented:]])
        loss, _ = vae_loss(vae, batch, params.alpha)
        _descend(optimizer, loss, vae)
        schedule.step()
    return vae.eval()


def train_prior(
    vae: SkillVAE,
    observations: Tensor,
    actions: Tensor,
    names: Sequence[str],
    action_names: Sequence[str],
    params: PriorParams,
    seed: int,
) -> SkillPrior:
    """The skill prior of one arm and task, for a trained VAE.

    Args:
        observations: (N, D), where the windows start, in the units of the layout ``names``.
        actions: (N, H, A), the windows, whose dimensions are called ``action_names``.
    """
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    prior = SkillPrior(names, vae.latent_dim, params.hidden, params.layers)
    observations, actions = moved_copies(
        observations, actions, names, action_names, params.symmetry, generator
    )
    prior.normalizer.fit(observations, names)
    mu_z, log_sigma_z = vae.encode_all(actions)
    optimizer = torch.optim.AdamW(
        prior.network.parameters(),
        params.learning_rate,
        weight_decay=params.weight_decay,
        fused=True,
    )
    schedule = _annealed(optimizer, params.steps)
    blur = params.input_noise * prior.normalizer.noise_scale()
    for _ in range(params.steps):
        index = torch.randint(len(observations), (params.batch,), generator=generator)
        seen = observations[index]
        seen = seen + blur * torch.randn(seen.shape, generator=generator)
        loss = task_loss(prior, seen, mu_z[index], log_sigma_z[index])
        _descend(optimizer, loss, prior)
        schedule.step()
    return prior.eval()


def _annealed(optimizer: torch.optim.Optimizer, steps: int) -> torch.optim.lr_scheduler.LRScheduler:
    return torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, max(steps, 1))


def _descend(optimizer: torch.optim.Optimizer, loss: Tensor, model: nn.Module) -> None:
    optimizer.zero_grad(set_to_none=True)
    loss.backward()
    nn.utils.clip_grad_norm_(model.parameters(), 10.0, foreach=True)
    optimizer.step()
