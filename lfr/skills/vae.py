"""The skill VAE: an action sequence of H control steps as a point in a latent space of Z skills.

Encoder q(z|a) and decoder p(a|z) are LSTMs, as in SPiRL (Pertsch et al. 2021) and in the paper's
part V.A: 128 hidden units, H = 10, Z = 10.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from lfr.skills.gaussian import kl_to_standard_normal, sample

LOG_SIGMA_RANGE = (-6.0, 2.0)
CHUNK = 2**14  # windows encoded together; an LSTM keeps H x hidden numbers of each


class SkillVAE(nn.Module):
    """Encodes actions (B, H, A) to ``(mu, log_sigma)``, (B, Z) each, and decodes z (B, Z) to them.

    Actions are the controller's, in [-1, 1]. ``execute`` of a skill's actions are carried out
    before the next skill is chosen; None carries out all, as the paper does.
    """

    def __init__(
        self,
        horizon: int,
        action_dim: int,
        latent_dim: int,
        hidden: int,
        execute: int | None = None,
    ) -> None:
        super().__init__()
        self.horizon, self.action_dim = horizon, action_dim
        self.execute = min(execute or horizon, horizon)
        self.latent_dim, self.hidden = latent_dim, hidden
        self.encoder = nn.LSTM(action_dim, hidden, batch_first=True)
        self.posterior = nn.Linear(hidden, 2 * latent_dim)
        self.initial = nn.Linear(latent_dim, 2 * hidden)
        self.decoder = nn.LSTM(latent_dim, hidden, batch_first=True)
        self.output = nn.Linear(hidden, action_dim)

    def encode(self, actions: Tensor) -> tuple[Tensor, Tensor]:
        """The posterior q(z|a) of actions (B, H, A): mu and log_sigma, (B, Z) each."""
        _, (hidden, _) = self.encoder(actions)
        mu, log_sigma = self.posterior(hidden[-1]).chunk(2, dim=-1)
        return mu, log_sigma.clamp(*LOG_SIGMA_RANGE)

    @torch.no_grad()
    def encode_all(self, actions: Tensor) -> tuple[Tensor, Tensor]:
        """`encode` without gradients for any number of windows, some at a time to spare memory.

        What it gives lies where ``actions`` does, wherever the network is.
        """
        device = self.output.weight.device
        parts = [self.encode(some.to(device)) for some in actions.split(CHUNK)]
        mu, log_sigma = (torch.cat(part).to(actions.device) for part in zip(*parts, strict=True))
        return mu, log_sigma

    def reconstruct(self, z: Tensor) -> Tensor:
        """The decoder's mean action sequence, unclipped, (B, H, A): what Eq. 3 compares."""
        hidden, cell = self.initial(z).chunk(2, dim=-1)
        repeated = z[:, None, :].expand(-1, self.horizon, -1)  # (B, H, Z)
        state = (hidden[None].contiguous(), cell[None].contiguous())
        features, _ = self.decoder(repeated.contiguous(), state)
        return self.output(features)

    def decode(self, z: Tensor) -> Tensor:
        """Actions that an arm can execute, clipped to [-1, 1], (B, H, A)."""
        return self.reconstruct(z).clamp(-1.0, 1.0)

    def carry_out(self, z: Tensor) -> Tensor:
        """The first ``execute`` of the decoded actions, (B, execute, A)."""
        return self.decode(z)[:, : self.execute]


def vae_loss(vae: SkillVAE, actions: Tensor, alpha: float) -> tuple[Tensor, dict[str, Tensor]]:
    """Eq. 2 and the first two terms of Eq. 3 for actions (B, H, A).

    Eq. 3 prints the reconstruction of ``z_i`` and sums over i = 1..H; it must be the actions',
    since the sum runs over the horizon. Here it is the mean over batch, horizon and action
    dimensions, and the divergence is summed over latent dimensions, so ``alpha`` is comparable
    across H.
    """
    mu, log_sigma = vae.encode(actions)
    reconstruction = vae.reconstruct(sample(mu, log_sigma))
    error = (reconstruction - actions).square().mean()
    divergence = kl_to_standard_normal(mu, log_sigma).mean()
    loss = error + alpha * divergence
    return loss, {"reconstruction": error.detach(), "kl": divergence.detach()}


def reconstruction_rmse(vae: SkillVAE, actions: Tensor) -> Tensor:
    """Root-mean-square error per action dimension, (A,), of the posterior mean's decoding."""
    squares = torch.zeros(vae.action_dim, dtype=torch.float64)
    with torch.no_grad():
        for some in actions.split(CHUNK):
            decoded = vae.decode(vae.encode(some)[0])
            squares += (decoded - some).square().sum(dim=(0, 1), dtype=torch.float64)
    return (squares / actions[..., 0].numel()).sqrt().float()
