"""A transfer's models in folders, small and untrained, for the point that moves on a line."""

from __future__ import annotations

from pathlib import Path

import torch

from lfr.mapping.generator import Generator
from lfr.mapping.saved_generators import MappingSeen, save_generator
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.library import transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen
from lfr.skills.vae import SkillVAE
from lfr.transfer.methods.initialization import TrainedModels
from tests.skills.made_up import save_models

from .point import NAMES

SCENARIO = Scenario("s", ("lift",), {"a": "other", "b": "new"})
_, TRANSFER = transfers_of(SCENARIO)  # from a to b
SEEN = Seen("a", ("new",), {}, 0)
MAPPED = MappingSeen("s-b-new", "a", "b", ("a/lift+new", "b/lift"), ("lift",), {}, 0)


def saved_models(folder: Path) -> TrainedModels:
    """Both VAEs, the source's prior of the new task, and G."""
    torch.manual_seed(1)
    skills, mapping = transfer_models(SCENARIO, TRANSFER, folder / "skills"), folder / "mapping"
    vaes = SkillVAE(3, 2, 4, 8), SkillVAE(3, 2, 4, 8)
    prior = SkillPrior(NAMES, latent_dim=4, hidden=16, layers=2)
    prior.normalizer.mean.fill_(0.5)
    save_models(skills["source"], vaes[0], {"new": prior})
    save_models(skills["target"], vaes[1], {})
    save_generator(mapping / "g", Generator(4, 16, 3), MAPPED)
    return TrainedModels(TRANSFER, skills, mapping)
