"""Acting by skills: a prior chooses, a translation brings it to another arm, a decoder does it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lfr.skills.resized import resized_vae
from lfr.skills.saved_models import check_actions, load_prior, load_vae
from lfr.skills.vae import SkillVAE

Distribution = tuple[Tensor, Tensor]
"""``(mu, log_sigma)``, (B, Z) each."""


@dataclass(frozen=True)
class SkillPolicy:
    """Acts with the mean skill of a prior, through a translation between latent spaces.

    Attributes:
        prior: observations (B, D) to a distribution in the source's latent space.
        translate: that distribution, and the observation, to one in the latent space of
            ``decoder``: G, or nothing at all.
        decoder: the skill VAE whose decoder turns z into actions.
    """

    prior: Callable[[Tensor], Distribution]
    translate: Callable[[Tensor, Tensor, Tensor], Distribution]
    decoder: SkillVAE

    def reset(self, seed: int) -> None:
        """Nothing is remembered and nothing drawn."""

    @torch.inference_mode()
    def act(self, observation: np.ndarray) -> np.ndarray:
        """The next skill's actions, as many as are carried out, (n, A), for an observation (D,)."""
        seen = torch.as_tensor(observation, dtype=torch.float32)[None]
        mu, _ = self.translate(*self.prior(seen), seen)
        return self.decoder.carry_out(mu, seen)[0].double().numpy()


def untranslated(mu: Tensor, log_sigma: Tensor, observation: Tensor) -> Distribution:
    """The identity: for an arm's own prior and decoder."""
    return mu, log_sigma


def recoded(source: SkillVAE, target: SkillVAE) -> Callable[[Tensor, Tensor, Tensor], Distribution]:
    """Translate by the actions themselves: decode with the source's VAE, encode with the target's.

    It needs a shared action space, and says how much of the new task the target's VAE can express.
    """

    def translate(mu: Tensor, log_sigma: Tensor, observation: Tensor) -> Distribution:
        return target.encode(source.decode(mu, observation), observation)

    return translate


@dataclass(frozen=True)
class SkillFiles:
    """A skill prior and the decoder that acts.

    Attributes:
        prior: folder of the skill prior.
        decoder: folder of the skill VAE whose decoder acts.
        encoder: folder of the skill VAE of the prior's own arm, if its decoded actions are to be
            encoded again by ``decoder``'s encoder.
    """

    prior: str
    decoder: str
    encoder: str | None = None

    def load(self, robot: str) -> SkillPolicy:
        """Raises DataError where a folder holds no such model, a damaged one or other actions."""
        check_actions(Path(self.decoder), robot)
        decoder = load_vae(Path(self.decoder))
        translate = untranslated
        if self.encoder is not None:
            check_actions(Path(self.encoder), robot)
            translate = recoded(load_vae(Path(self.encoder)), decoder)
        return SkillPolicy(load_prior(Path(self.prior)), translate, decoder)


@dataclass(frozen=True)
class UntranslatedFiles:
    """A source's skill prior and skill VAE, for an arm to which its actions mean something else.

    They are carried out as they are, joint by joint (`lfr.skills.resized`).

    Attributes:
        target: folder of the target's own skill VAE, which says how many actions it has.
    """

    prior: str
    decoder: str
    target: str

    def load(self, robot: str) -> SkillPolicy:
        """Raises DataError where a folder holds no such model, or a damaged one."""
        size = load_vae(Path(self.target)).action_dim
        decoder = resized_vae(load_vae(Path(self.decoder)), size)
        return SkillPolicy(load_prior(Path(self.prior)), untranslated, decoder)
