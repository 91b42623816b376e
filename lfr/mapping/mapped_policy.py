"""A source's skill prior that acts on the target through G, before any learning there."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.mapping.saved_generators import load_generator
from lfr.skills.saved_models import check_actions, load_prior, load_vae
from lfr.skills.skill_policy import SkillPolicy


@dataclass(frozen=True)
class MappedFiles:
    """The folders of a skill prior, of G that translates it, and of the skill VAE that acts."""

    prior: str
    generator: str
    decoder: str

    def load(self, robot: str) -> SkillPolicy:
        """Raises DataError where a folder holds no such model, a damaged one or other actions."""
        check_actions(Path(self.decoder), robot)
        g, decoder = load_generator(Path(self.generator)), load_vae(Path(self.decoder))
        return SkillPolicy(load_prior(Path(self.prior)), g.at, decoder)
