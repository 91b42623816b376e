"""All variants of one transfer and repetition, as jobs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lfr.mapping.mapping_jobs import mapping_job
from lfr.mapping.mapping_params import MappingParams
from lfr.scenarios import Role, Scenario, Transfer
from lfr.skills.demonstrations import DATASETS
from lfr.skills.library import RoleModels
from lfr.skills.skill_params import SkillsParams
from studies.ablations.any_task import AnyTaskJob, fit_any_task
from studies.ablations.maps import MapJob, fit_map, map_jobs
from studies.ablations.shared_vae import SharedJob, fit_shared
from studies.ablations.wrong_task import WrongTaskJob, make_wrong_task

Variant = MapJob | SharedJob | AnyTaskJob | WrongTaskJob


def variant_jobs(
    scenario: Scenario,
    transfer: Transfer,
    skills: SkillsParams,
    mapping: MappingParams,
    seed: int,
    models: Mapping[Role, RoleModels],
    other: Mapping[Role, RoleModels],
    folder: Path,
    datasets: Path = DATASETS,
) -> dict[str, Variant]:
    """By name, what to train into ``folder/<name>/{g | vae, prior | prior}``.

    Args:
        seed: of the repetition.
        models: its skill models.
        other: another repetition's.
    """
    own = mapping_job(
        scenario, transfer, mapping, skills.held_out, seed, models, folder, datasets
    )  # fmt: skip
    data = str(datasets)
    return {
        **map_jobs(own, other["source"], folder),
        "shared_vae": SharedJob(
            scenario, transfer, skills, seed, str(folder / "shared_vae"), data
        ),
        "any_task": AnyTaskJob(
            scenario, transfer, skills.prior, skills.held_out, seed, models["target"],
            str(folder / "any_task"), data,
        ),
        "wrong_task": WrongTaskJob(transfer, models["source"], str(folder / "wrong_task")),
    }  # fmt: skip


def fit_variant(job: Variant) -> dict[str, Any]:
    """Train and save what a job names; its report."""
    match job:
        case MapJob():
            return fit_map(job)
        case SharedJob():
            return fit_shared(job)
        case AnyTaskJob():
            return fit_any_task(job)
        case WrongTaskJob():
            return make_wrong_task(job)
