"""What the ablations' methods begin with, and that their policies are saved and found again."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
import torch

from lfr.errors import DataError
from lfr.mapping.generator import Generator
from lfr.mapping.saved_generators import save_generator
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import save_prior, save_vae
from lfr.skills.vae import SkillVAE
from lfr.transfer.methods import METHODS, Method, initialize
from lfr.transfer.methods.initialization import TrainedModels
from lfr.transfer.model import load_policy, save_policy
from lfr.transfer.transfer_params import TransferParams
from studies.ablations.other_task import OtherTaskPrior, save_other_task
from studies.methods import methods as methods_with
from tests.transfer.point import NAMES, point_params
from tests.transfer.saved_models import MAPPED, SEEN, saved_models


@pytest.fixture
def params() -> TransferParams:
    return point_params()


@pytest.fixture
def models(tmp_path: Path) -> TrainedModels:
    return saved_models(tmp_path)


@pytest.fixture
def methods(models: TrainedModels, tmp_path: Path) -> Mapping[str, Method]:
    """With one variant of each kind; what of other tasks there is sees two of three numbers."""
    torch.manual_seed(5)
    variants = tmp_path / "variants"
    save_generator(variants / "only_lift" / "g", Generator(4, 16, 3), MAPPED)
    save_vae(variants / "shared_vae" / "vae", SkillVAE(3, 2, 4, 8), SEEN)
    save_prior(variants / "shared_vae" / "prior", models.source_prior(), SEEN)
    inner = SkillPrior(("x_pos", "goal_to_x"), latent_dim=4, hidden=16, layers=2)
    prior = OtherTaskPrior(NAMES, inner.layout_names, (0, 2), 4, 16, 2)
    prior.inner.load_state_dict(inner.state_dict())
    for name in ("any_task", "wrong_task"):
        save_other_task(variants / name / "prior", prior, SEEN)
    return methods_with(variants)


OWN = ("only_lift", "spirl", "spirl_no_prior", "shared_vae", "wrong_task")


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
    if name != "spirl_no_prior":  # before any learning, the policy is the prior it is held near
        actor = begun.actor
        torch.testing.assert_close(actor.policy(observation), actor.prior(observation))


def test_one_common_task_gives_another_phi(
    models: TrainedModels, params: TransferParams, methods: Mapping[str, Method]
) -> None:
    observation = torch.randn(5, 3)
    names = ("lfr", "only_lift")
    whole, only = (initialize(name, models, params, 0, methods).actor for name in names)
    assert not torch.allclose(only.prior(observation)[0], whole.prior(observation)[0])
    z = torch.randn(2, 4)
    torch.testing.assert_close(only.decoder.carry_out(z), whole.decoder.carry_out(z))


def test_a_new_policy_depends_on_the_seed_alone(
    models: TrainedModels, params: TransferParams, methods: Mapping[str, Method]
) -> None:
    observation, name = torch.randn(5, 3), "spirl_no_prior"
    one, again, other = (initialize(name, models, params, seed, methods) for seed in (3, 3, 4))
    found = [begun.actor.policy(observation)[0] for begun in (one, again, other)]
    assert torch.equal(found[0], found[1])
    assert not torch.equal(found[0], found[2])
    assert not one.actor.prior(observation)[0].any()


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


def test_a_missing_variant_is_named(
    models: TrainedModels, params: TransferParams, tmp_path: Path
) -> None:
    with pytest.raises(DataError, match=r"studies\.ablations\.variants"):
        initialize("shared_vae", models, params, 0, methods_with(tmp_path / "nothing"))
