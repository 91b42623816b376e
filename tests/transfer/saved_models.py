"""A transfer's models in folders, small and untrained, for the point that moves on a line."""

from __future__ import annotations

from pathlib import Path

import torch

from lfr.mapping.artifacts import MappingSeen, save_generator
from lfr.mapping.generator import Generator
from lfr.scenarios import Transfer
from lfr.skills.artifacts import Seen, save_prior, save_vae
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.transfer.methods.initialization import TrainedModels

from .point import NAMES

TRANSFER = Transfer("s-b-new", "s", "a", "b", ("lift",), "new")
SEEN = Seen("s", "a", "source", ("new",), {}, 0)
MAPPED = MappingSeen("s-b-new", "a", "b", ("lift",), {}, 0)


def saved_models(folder: Path) -> TrainedModels:
    """Both VAEs, the source's prior of the new task, and G."""
    torch.manual_seed(1)
    skills, mapping = folder / "skills", folder / "mapping"
    for role in ("source", "target"):
        save_vae(skills / role / "vae", SkillVAE(3, 2, 4, 8), SEEN)
    prior = SkillPrior(NAMES, latent_dim=4, hidden=16, layers=2)
    prior.normalizer.mean.fill_(0.5)
    save_prior(skills / "source" / "prior-new", prior, SEEN)
    save_generator(mapping / "g", Generator(4, 16, 3), MAPPED)
    return TrainedModels(TRANSFER, skills, mapping)
