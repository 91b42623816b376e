"""Models and links by other choices than the main job's: what plain and plain_parts do alike."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lfr.errors import ParameterError
from lfr.evaluation.questions import model_trials
from lfr.jobs import run_jobs
from lfr.mapping.models import fit_mapping, mapping_job
from lfr.mapping.training import MappingParams
from lfr.params import read_section
from lfr.scenarios import Transfer, scenario, visible_tasks
from lfr.skills.demonstrations import DATASETS as OURS
from lfr.skills.models import fit_model, model_jobs, model_report, roles_of
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._links import CODE as LINK_CODE
from pipeline.paper._links import judged_links
from pipeline.paper._plain import DATASETS as PLAIN
from pipeline.paper._plain import plain_section
from pipeline.paper._spent import Spent
from pipeline.paper._stage import PARAMS

CODE = (
    "lfr.skills", "lfr.mapping", "lfr.models", "lfr.data", "lfr.columns", "lfr.scenarios",
    "lfr.seeds", "lfr.robots", "lfr.tasks",
)  # fmt: skip
LINKS = ("own_arm", "identity", "recoded", "mapped", "oracle")
PARTS = ("demonstrations", "execute", "vae", "prior", "mapping")
"""What section ``plain`` sets back: ``record``; how much of a skill is carried out, and the rest of
``skills.vae``; ``skills.prior``; ``mapping``."""


@dataclass(frozen=True)
class Choices:
    """What models are trained on and how: the main job's, or the paper's reading, part by part.

    Attributes:
        datasets: the folder of them, <robot>-<task> each.
    """

    datasets: Path
    skills: SkillsParams
    mapping: MappingParams


@dataclass(frozen=True)
class Trained:
    """One transfer's models, a folder and a report for each seed."""

    folders: dict[int, Path]
    runs: list[dict[str, Any]]
    spent: Spent


def choices(set_back: Collection[str]) -> Choices:
    """The main job's, but for those of `PARTS` that are set back to the paper's reading.

    Raises:
        ParameterError: a section of either parameter file does not fit, or ``plain`` changes what
            is in no part.
    """
    ours, plain = read_section(SkillsParams, "skills"), plain_section(SkillsParams, "skills")
    if replace(plain, vae=ours.vae, prior=ours.prior) != ours:
        raise ParameterError(f"{PARAMS}: plain.skills: only vae and prior may differ")
    execute, vae, prior = ((plain if part in set_back else ours)
                           for part in ("execute", "vae", "prior"))  # fmt: skip
    return Choices(
        PLAIN if "demonstrations" in set_back else OURS,
        replace(ours, vae=replace(vae.vae, execute=execute.vae.execute), prior=prior.prior),
        plain_section(MappingParams, "mapping")
        if "mapping" in set_back
        else read_section(MappingParams, "mapping"),
    )


def train(
    transfer: Transfer, chosen: Choices, seeds: Collection[int], stage: str, name: str
) -> Trained:
    """Train skill models and the mapping of every seed, as the stage models trains its own.

    Args:
        stage, name: of the unfinished work, in which the models' folders lie.
    """
    known = scenario(transfer.scenario)
    datasets = {
        chosen.datasets / f"{robot}-{task}"
        for role, robot in roles_of(transfer).items()
        for task in visible_tasks(known, robot, role)
    }
    work = unfinished_work(
        stage, name, known, chosen.skills, chosen.mapping, *rows_of(sorted(datasets)),
        code=CODE,
    )  # fmt: skip
    spent = Spent(work)
    runs, folders = [], {seed: work / f"models/seed-{seed}" for seed in seeds}
    for seed, folder in folders.items():
        title = f"{stage} {name} seed {seed}"
        jobs, needs = model_jobs(
            known, transfer, chosen.skills, seed, folder / "skills", chosen.datasets
        )
        fitted = run_jobs(fit_model, jobs, after=needs, work=work, description=title, unit="model")
        phi = mapping_job(
            known, transfer, chosen.mapping, chosen.skills.held_out, seed, folder / "skills",
            folder / "mapping", chosen.datasets,
        )  # fmt: skip
        (mapped,) = run_jobs(fit_mapping, [phi], work=work, description=title, unit="mapping")
        runs.append({"seed": seed, "skills": model_report(jobs, fitted), "mapping": mapped})
    return Trained(folders, runs, spent)


def judge(
    transfer: Transfer, folders: Mapping[int, Path], episodes: int, stage: str, name: str
) -> dict[str, dict[str, list[Any]]]:
    """Success of the `LINKS` of each seed's folder of models, as the stage zero_shot writes it."""
    trials = {
        (seed, link): trial
        for seed, folder in folders.items()
        for link, trial in model_trials(transfer, folder, episodes).items()
        if link in LINKS
    }
    work = unfinished_work(stage, name, code=LINK_CODE)
    return judged_links(trials, work, f"{stage} {name}")
