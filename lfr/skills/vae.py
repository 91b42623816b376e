"""The skill VAE: an action sequence of H control steps as a point in a latent space of Z skills.

Encoder q(z|a) and decoder p(a|z) are LSTMs, as in SPiRL (Pertsch et al. 2021) and in the paper's
part V.A: 128 hidden units, H = 10, Z = 10.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor, nn

from lfr.skills.condition import Conditioned
from lfr.skills.gaussian import LOG_SIGMA_RANGE, kl_to_standard_normal, sample
from lfr.spaces import ROBOT_STATE

GRIPPER_COMMAND = ROBOT_STATE.index("gripper_command")
CHUNK = 2**14  # windows encoded together; an LSTM keeps H x hidden numbers of each


class SkillVAE(Conditioned):
    """Encodes actions (B, H, A) to ``(mu, log_sigma)``, (B, Z) each, and decodes z (B, Z) to them.

    Actions are the controller's, in [-1, 1]. ``execute`` of a skill's actions are carried out
    before the next skill is chosen; None carries out all, as the paper does.

    Args:
        state_names: what encoder and decoder see of the state in which a skill begins, the first
            dimensions of an observation: q(z|a, s) and p(a|z, s). None of them is the paper's. The
            same motion of an arm's joints is another motion of the hand in another posture, so z
            can say the latter only where the posture is seen.
        turned: whether they see that in the frame of the hand's azimuth (`Normalizer`).
        whole_release: whether a skill that opens a hand which holds is carried out to its end all
            the same. Where a prior hesitates to let go, its mean skill opens the hand late in it,
            and who carries out the first half alone puts it off for ever (docs/joint-space.md).
    """

    def __init__(
        self,
        horizon: int,
        action_dim: int,
        latent_dim: int,
        hidden: int,
        execute: int | None = None,
        state_names: Sequence[str] = (),
        turned: bool = False,
        whole_release: bool = False,
    ) -> None:
        super().__init__(state_names, turned)
        self.whole_release = whole_release
        self.horizon, self.action_dim = horizon, action_dim
        self.execute = min(execute or horizon, horizon)
        self.latent_dim, self.hidden = latent_dim, hidden
        self.encoder = nn.LSTM(action_dim + self.feature_size, hidden, batch_first=True)
        self.posterior = nn.Linear(hidden, 2 * latent_dim)
        self.initial = nn.Linear(latent_dim + self.feature_size, 2 * hidden)
        self.decoder = nn.LSTM(latent_dim + self.feature_size, hidden, batch_first=True)
        self.output = nn.Linear(hidden, action_dim)

    def encode(self, actions: Tensor, observations: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """The posterior q(z|a) of actions (B, H, A): mu and log_sigma, (B, Z) each.

        Args:
            observations: (B, D), where they begin; needed where it sees of the state at all.
        """
        return self.encode_beside(actions, self._seen(observations))

    def encode_beside(self, actions: Tensor, features: Tensor | None) -> tuple[Tensor, Tensor]:
        """`encode`, given the `features` (B, F) of the observations; None where it sees nothing."""
        if features is not None:
            features = features[:, None].expand(-1, self.horizon, -1)
            actions = torch.cat([actions, features], dim=-1)
        _, (hidden, _) = self.encoder(actions)
        mu, log_sigma = self.posterior(hidden[-1]).chunk(2, dim=-1)
        return mu, log_sigma.clamp(*LOG_SIGMA_RANGE)

    @torch.no_grad()
    def encode_all(
        self, actions: Tensor, observations: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        """`encode` without gradients for any number of windows, some at a time to spare memory.

        What it gives lies where ``actions`` does, wherever the network is.
        """
        device = self.output.weight.device
        parts = [
            self.encode(some.to(device), None if where is None else where.to(device))
            for some, where in _split(actions, observations)
        ]
        mu, log_sigma = (torch.cat(part).to(actions.device) for part in zip(*parts, strict=True))
        return mu, log_sigma

    def reconstruct(
        self, z: Tensor, observations: Tensor | None = None, steps: int | None = None
    ) -> Tensor:
        """The decoder's mean action sequence, unclipped, (B, H, A): what Eq. 3 compares.

        Args:
            observations: (B, D), where the skills begin; needed where it sees of the state at all.
            steps: of the H actions, the first so many alone.
        """
        return self.reconstruct_beside(z, self._seen(observations), steps)

    def reconstruct_beside(
        self, z: Tensor, features: Tensor | None, steps: int | None = None
    ) -> Tensor:
        """`reconstruct`, given the `features` (B, F) of the observations, or None."""
        if features is not None:
            z = torch.cat([z, features], dim=-1)
        hidden, cell = self.initial(z).chunk(2, dim=-1)
        repeated = z[:, None, :].expand(-1, steps or self.horizon, -1)  # (B, H, Z + F)
        state = (hidden[None].contiguous(), cell[None].contiguous())
        decoded, _ = self.decoder(repeated.contiguous(), state)
        return self.output(decoded)

    def decode(self, z: Tensor, observations: Tensor | None = None) -> Tensor:
        """Actions that an arm can execute, clipped to [-1, 1], (B, H, A)."""
        return self.reconstruct(z, observations).clamp(-1.0, 1.0)

    def carry_out(self, z: Tensor, observations: Tensor | None = None) -> list[Tensor]:
        """What is carried out of B skills before the next ones are chosen, (n, A) of each.

        The first ``execute`` actions, or all H of a skill that lets go (``whole_release``).

        Args:
            observations: (B, D), which begin with `ROBOT_STATE` where ``whole_release`` is asked.
        """
        if not self.whole_release:
            return list(self.reconstruct(z, observations, self.execute).clamp(-1.0, 1.0))
        if observations is None:
            raise ValueError("whether a hand holds is in the observations; give it those too")
        actions = self.decode(z, observations)
        opens = actions[..., -1].amin(dim=-1) < 0.0
        whole = opens & (observations[:, GRIPPER_COMMAND] > 0.0)
        return [
            skill if to_its_end else skill[: self.execute]
            for skill, to_its_end in zip(actions, whole.tolist(), strict=True)
        ]

    def _seen(self, observations: Tensor | None) -> Tensor | None:
        """The features (B, F) of the observations, or None where it sees nothing of them."""
        if not self.state_names:
            return None
        if observations is None:
            raise ValueError("this skill VAE sees the state; give it the observations too")
        return self.features(observations)


JOINTS_SHARE = 0.3
"""Weight of a squared error of the joints beside one of the hand, which does not see all of it."""


def action_error(error: Tensor, jacobian: Tensor | None = None) -> Tensor:
    """The mean squared error of actions off by ``error`` (B, H, A).

    Args:
        jacobian: (B, 6, A - 1), of the hand's motion by the joints' where the windows begin. The
            hand's error then counts in place of the joints', in units of a hand's motion
            (`lfr.skills.hand_motion`), and these with `JOINTS_SHARE`; the gripper's as it is.
    """
    if jacobian is None:
        return error.square().mean()
    joints = error[..., :-1]
    hand = joints @ jacobian.mT  # (B, H, 6)
    squares = hand.square().sum(-1) + JOINTS_SHARE * joints.square().sum(-1)
    return (squares + error[..., -1].square()).mean() / error.shape[-1]


def vae_loss(
    vae: SkillVAE,
    actions: Tensor,
    alpha: float,
    features: Tensor | None = None,
    jacobian: Tensor | None = None,
) -> tuple[Tensor, dict[str, Tensor]]:
    """Eq. 2 and the first two terms of Eq. 3 for actions (B, H, A).

    Eq. 3 prints the reconstruction of ``z_i`` and sums over i = 1..H; it must be the actions',
    since the sum runs over the horizon. Here it is the mean over batch, horizon and action
    dimensions, and the divergence is summed over latent dimensions, so ``alpha`` is comparable
    across H.

    Args:
        features: (B, F), what the VAE sees of the states in which they begin, if it sees these.
        jacobian: of the hand by the joints, (B, 6, A - 1), where errors count at the hand.
    """
    mu, log_sigma = vae.encode_beside(actions, features)
    reconstruction = vae.reconstruct_beside(sample(mu, log_sigma), features)
    error = action_error(reconstruction - actions, jacobian)
    divergence = kl_to_standard_normal(mu, log_sigma).mean()
    loss = error + alpha * divergence
    return loss, {"reconstruction": error.detach(), "kl": divergence.detach()}


def reconstruction_rmse(
    vae: SkillVAE, actions: Tensor, observations: Tensor | None = None
) -> Tensor:
    """Root-mean-square error per action dimension, (A,), of the posterior mean's decoding."""
    squares = torch.zeros(vae.action_dim, dtype=torch.float64)
    with torch.no_grad():
        for some, where in _split(actions, observations):
            decoded = vae.decode(vae.encode(some, where)[0], where)
            squares += (decoded - some).square().sum(dim=(0, 1), dtype=torch.float64)
    return (squares / actions[..., 0].numel()).sqrt().float()


def _split(actions: Tensor, observations: Tensor | None) -> Iterator[tuple[Tensor, Tensor | None]]:
    """Both in chunks of as many rows."""
    parts = actions.split(CHUNK)
    where = [None] * len(parts) if observations is None else observations.split(CHUNK)
    yield from zip(parts, where, strict=True)
