"""Which models transfers need and share, and that a role gets none that has seen too much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from lfr.errors import DataError, LfrError
from lfr.evaluation.chain import chain_trials
from lfr.mapping.mapping_jobs import fit_mapping, mapping_job
from lfr.mapping.mapping_params import MappingParams
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.library import (
    RoleModels,
    needed_models,
    prior_tasks,
    roles_of,
    skill_folder,
    transfer_models,
)
from lfr.skills.model_jobs import VAETraining, model_jobs, model_seed
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen, save_prior, save_vae
from lfr.skills.skill_params import SkillsParams
from lfr.skills.vae import SkillVAE
from lfr.transfer.methods.initialization import TrainedModels

from .made_up import save_models

FIRST = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})
SECOND = Scenario("s2", ("lift", "nut_assembly"), {"panda": "stack", "sawyer": "pick_place"})
TRANSFER = transfers_of(FIRST)[0]  # lift from sawyer to panda
ALL = [(scenario, transfer) for scenario in (FIRST, SECOND) for transfer in transfers_of(scenario)]


def test_priors_of_each_role() -> None:
    assert prior_tasks(FIRST, "sawyer", "source") == ("pick_place", "nut_assembly", "lift")
    assert prior_tasks(FIRST, "panda", "target") == ("pick_place", "nut_assembly")
    assert prior_tasks(FIRST, "panda", "oracle") == ("lift",)
    assert roles_of(TRANSFER) == {"source": "sawyer", "target": "panda", "oracle": "panda"}


def test_one_transfer_needs_what_its_roles_may_see() -> None:
    one = [(FIRST, TRANSFER)]
    common = ("nut_assembly", "pick_place")
    assert needed_models("sawyer", one) == {("lift", *common): ("lift", *common)}
    assert needed_models("panda", one) == {common: common, ("lift", *common): ("lift",)}
    assert needed_models("ur5e", one) == {}


def test_transfers_share_models() -> None:
    """Panda's models of these three tasks are an oracle's in one and the source's in another."""
    needed = needed_models("panda", ALL)
    shared = ("lift", "nut_assembly", "pick_place")
    assert needed[shared] == shared
    assert len(needed) == 5  # of six roles
    roles = [
        (transfer.name, role)
        for scenario, transfer in ALL
        for role, models in transfer_models(scenario, transfer, Path("models/skills")).items()
        if models.name == "panda/lift+nut_assembly+pick_place"
    ]
    assert roles == [("s1-panda-lift", "oracle"), ("s2-sawyer-pick_place", "source")]


def test_priors_are_trained_after_their_vae_and_where_roles_look_for_it() -> None:
    jobs = model_jobs("panda", needed_models("panda", ALL), SkillsParams(), 0, Path("skills"))
    assert len(jobs) == 5
    for vae, priors in jobs.items():
        assert priors.spec.tasks
        assert priors.needs == (vae,)
        assert priors.spec.vae is vae.spec
    names = {vae.spec.models.path for vae in jobs}
    assert skill_folder(Path("skills"), "panda", ["pick_place", "nut_assembly"]).path in names


def test_no_two_models_start_from_the_same_weights() -> None:
    specs = [
        VAETraining(robot, tasks, SkillsParams(), seed, "skills")
        for robot in ("panda", "sawyer")
        for tasks in (("lift",), ("lift", "stack"))
        for seed in (0, 1)
    ]
    seeds = {model_seed(spec, prior) for spec in specs for prior in (None, "lift", "stack")}
    assert len(seeds) == 3 * len(specs)


@pytest.fixture
def skills(tmp_path: Path) -> dict[Any, RoleModels]:
    """The models of `TRANSFER`, but the target's VAE and a prior of its have seen the new task."""
    models = transfer_models(FIRST, TRANSFER, tmp_path)
    vae, prior = SkillVAE(2, 2, 2, 2), SkillPrior(("number.x",), 2, 2, 1)
    for role in ("source", "oracle"):
        save_models(models[role], vae, {"lift": prior})
    folder = skill_folder(tmp_path, "panda", TRANSFER.common)
    save_vae(folder.vae, vae, Seen("panda", (*TRANSFER.common, "lift"), {}, 0))
    save_prior(folder.prior("lift"), prior, Seen("panda", ("lift",), {}, 0))
    return models


@pytest.mark.parametrize(
    "use",
    [
        lambda skills: skills["target"].vae(),
        lambda skills: skills["target"].prior("lift"),
        lambda skills: fit_mapping(
            mapping_job(FIRST, TRANSFER, MappingParams(), 0.1, 0, skills, Path("mapping"))
        ),
        lambda skills: chain_trials(TRANSFER, skills, Path("mapping"), 5),
        lambda skills: TrainedModels(TRANSFER, skills, Path("mapping")).target_vae(),
    ],
    ids=["vae", "prior", "mapping", "zero-shot", "transfer"],
)
def test_a_target_model_that_has_seen_the_new_task_is_refused(
    skills: dict[Any, RoleModels], use: Callable[[Any], object]
) -> None:
    with pytest.raises(LfrError, match=r"^demonstrations of 'lift' by panda are hidden.*'target'"):
        use(skills)


def test_the_same_models_are_the_oracles(skills: dict[Any, RoleModels]) -> None:
    """What is refused is the role, not the model."""
    assert skills["oracle"].vae().is_dir()
    assert skills["oracle"].prior("lift").is_dir()


def test_a_model_of_another_robot_is_refused(skills: dict[Any, RoleModels], tmp_path: Path) -> None:
    seen = Seen("sawyer", TRANSFER.common, {}, 0)
    save_vae(skill_folder(tmp_path, "panda", TRANSFER.common).vae, SkillVAE(2, 2, 2, 2), seen)
    with pytest.raises(DataError, match=r"another robot.*found sawyer, expected panda"):
        skills["target"].vae()
    with pytest.raises(DataError, match="missing"):
        replace(skills["target"], root=str(tmp_path / "nothing")).vae()
