"""What the ablations' methods begin with, and that their policies are saved and found again."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
import torch

from lfr.skills.prior import SkillPrior
from lfr.transfer.methods import METHODS, Method, initialize
from lfr.transfer.methods.initialization import TrainedModels
from lfr.transfer.model import load_policy, save_policy
from lfr.transfer.transfer_params import TransferParams
from studies.methods import methods as methods_with
from studies.spirl.other_task import OtherTaskPrior, save_other_task
from tests.transfer.point import NAMES, point_params
from tests.transfer.saved_models import SEEN, saved_models


@pytest.fixture
def params() -> TransferParams:
    return point_params()


@pytest.fixture
def models(tmp_path: Path) -> TrainedModels:
    return saved_models(tmp_path)


@pytest.fixture
def methods(models: TrainedModels, tmp_path: Path) -> Mapping[str, Method]:
    """SPiRL's prior sees two of three numbers."""
    torch.manual_seed(5)
    inner = SkillPrior(("x_pos", "goal_to_x"), latent_dim=4, hidden=16, layers=2)
    prior = OtherTaskPrior(NAMES, inner.layout_names, (0, 2), 4, 16, 2)
    prior.inner.load_state_dict(inner.state_dict())
    save_other_task(tmp_path / "spirl", prior, SEEN)
    return methods_with(tmp_path / "spirl")


OWN = ("spirl", "retarget")


def test_the_librarys_methods_are_there_as_they_are(methods: Mapping[str, Method]) -> None:
    assert {name: methods[name] for name in METHODS} == METHODS
    assert set(OWN) <= set(methods) - set(METHODS)


@pytest.mark.parametrize("name", OWN)
def test_every_method_begins_and_is_saved(
    name: str, models: TrainedModels, params: TransferParams, methods: Mapping[str, Method],
    tmp_path: Path,
) -> None:  # fmt: skip
    observation = torch.randn(5, 3)
    begun = initialize(name, models, params, 0, methods)
    expected = models.source_prior().normalizer(observation)
    torch.testing.assert_close(begun.normalizer(observation), expected)
    assert begun.layout_names == NAMES
    save_policy(tmp_path / "policy", begun.actor, {})
    again, _ = load_policy(tmp_path / "policy")
    torch.testing.assert_close(again.policy(observation), begun.actor.policy(observation))
    torch.testing.assert_close(again.prior(observation), begun.actor.prior(observation))
    # before any learning, the policy is the prior it is held near
    torch.testing.assert_close(begun.actor.policy(observation), begun.actor.prior(observation))


def test_who_begins_with_another_tasks_prior_sees_everything(
    models: TrainedModels, params: TransferParams, methods: Mapping[str, Method]
) -> None:
    """The prior that it is held near does not; SPiRL's policy may still learn to seek a goal."""
    actor = initialize("spirl", models, params, 0, methods).actor
    observation = torch.randn(64, 3)
    blind = actor.prior(observation)
    torch.testing.assert_close(actor.policy(observation), blind)
    moved = observation.clone()
    moved[:, 1] += 1.0  # goal_pos, which the prior knows nothing of
    torch.testing.assert_close(actor.prior(moved), blind)
    optimizer = torch.optim.Adam([p for p in actor.policy.parameters() if p.requires_grad])
    for _ in range(300):  # to answer with the goal
        optimizer.zero_grad()
        mu, _ = actor.policy(observation)
        loss = (mu[:, 0] - observation[:, 1]).square().mean()
        loss.backward()
        optimizer.step()
    assert float(loss.detach()) < 0.1


def test_without_the_studies_their_policies_are_refused_in_one_line(
    models: TrainedModels, params: TransferParams, methods: Mapping[str, Method], tmp_path: Path
) -> None:
    save_policy(tmp_path / "policy", initialize("spirl", models, params, 0, methods).actor, {})
    program = """
import sys
from pathlib import Path
from lfr.program import run_program
from lfr.transfer.model import load_policy
sys.exit(run_program(lambda: load_policy(Path("policy"))))
"""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "unknown kind of network" in line
    assert "found ResidualPriorPolicy, expected SkillPrior or " in line
