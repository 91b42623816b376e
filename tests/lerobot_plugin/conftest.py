"""A small policy for Lift, as the pipeline saves it and as `lfr export` writes it."""

from pathlib import Path

import pytest
import torch

from lfr.lerobot_plugin.export import Exported, export_policy
from lfr.mapping.generator import Generator
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.tasks import task
from lfr.transfer.actor import SkillActor
from lfr.transfer.extended_policy import MappedPolicy
from lfr.transfer.model import save_policy
from tests.transfer.conftest import one_thread as one_thread


@pytest.fixture(scope="package")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    torch.manual_seed(0)
    names = task("lift").observation.names

    def mapped() -> MappedPolicy:
        return MappedPolicy(SkillPrior(names, 4, hidden=16, layers=2), Generator(4, 16, 2))

    decoder = SkillVAE(10, 7, 4, hidden=16, execute=5)
    folder = tmp_path_factory.mktemp("models") / "seed-0"
    about = {"robot": "panda", "task": "lift", "transfer": "s1-panda-lift", "seed": 0}
    save_policy(folder, SkillActor(mapped(), mapped(), decoder), about)
    return folder


@pytest.fixture(scope="package")
def exported(saved: Path) -> Path:
    folder = saved.parent / "exported"
    assert export_policy(saved, folder) == Exported("panda", "lift")
    return folder
