"""Who may carry out whose actions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.columns import ActionSpace
from lfr.errors import DataError
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen, save_prior, save_vae
from lfr.skills.skill_policy import SkillFiles, UntranslatedFiles
from lfr.skills.vae import SkillVAE

NAMES = ("hand_pos.x", "hand_pos.y")


@pytest.fixture
def crane(tmp_path: Path) -> tuple[str, str]:
    """Prior and VAE of an arm that is known by its datasets alone."""
    torch.manual_seed(0)
    space = ActionSpace(("vx", "vy", "hand"), (-1.0,) * 3, (1.0,) * 3)
    seen = Seen("crane", ("push",), {}, 0, space)
    save_vae(tmp_path / "vae", SkillVAE(4, 3, 2, hidden=8, execute=2), seen)
    save_prior(tmp_path / "prior", SkillPrior(NAMES, 2, 8, 1), seen)
    return str(tmp_path / "prior"), str(tmp_path / "vae")


def test_another_external_arm_with_the_same_actions_carries_them_out(
    crane: tuple[str, str],
) -> None:
    for policy in (SkillFiles(*crane), SkillFiles(*crane, encoder=crane[1])):
        assert policy.load("puck").act(np.zeros(2)).shape == (2, 3)


def test_one_with_other_actions_has_as_many_as_its_own_vae(
    crane: tuple[str, str], tmp_path: Path
) -> None:
    seen = Seen("puck", ("push",), {}, 0)
    save_vae(tmp_path / "own", SkillVAE(4, 5, 2, hidden=8), seen)
    policy = UntranslatedFiles(*crane, str(tmp_path / "own")).load("puck")
    assert policy.act(np.zeros(2)).shape == (2, 5)


def test_a_simulated_arm_does_not(crane: tuple[str, str]) -> None:
    with pytest.raises(DataError, match="panda cannot carry out the actions of crane"):
        SkillFiles(*crane).load("panda")
