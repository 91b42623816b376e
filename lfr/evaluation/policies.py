"""Policies that have not learned on the target, by the folders of their models."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.skills.artifacts import load_prior, load_vae
from lfr.skills.policy import SkillPolicy, recoded, untranslated


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

    def load(self) -> SkillPolicy:
        """Raises DataError where a folder holds no such model, or a damaged one."""
        decoder = load_vae(Path(self.decoder))
        translate = untranslated
        if self.encoder is not None:
            translate = recoded(load_vae(Path(self.encoder)), decoder)
        return SkillPolicy(load_prior(Path(self.prior)), translate, decoder)
