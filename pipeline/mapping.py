"""Stage mapping: G and F of one transfer, and the chain of zero-shot success around them."""

import sys
from collections.abc import Mapping
from pathlib import Path

from lfr.environments.simulation import external_target
from lfr.evaluation.chain import chain_trials, train_and_measure
from lfr.evaluation.protocol import EvaluateParams
from lfr.external import ExternalArm, external_arms, without_environments
from lfr.mapping.mapping_jobs import mapping_job
from lfr.mapping.mapping_params import MappingParams
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import Role, Transfer
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.demonstrations import dataset_of
from lfr.skills.library import RoleModels, pipeline_models
from lfr.skills.saved_models import load_prior
from lfr.skills.skill_params import SkillsParams
from pipeline._stage import SeedParams, models_into, rows_of, unfinished_work, write_metrics


def main(transfer: str) -> None:
    """Train a transfer's mapping into models/mapping/<transfer> and measure its chain.

    The chain is left out where the target is simulated neither here nor in an environment of its
    own.
    """
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    params = read_section(MappingParams, "mapping")
    held_out = read_section(SkillsParams, "skills").held_out
    seed = read_section(SeedParams, "seeds").models
    known = external_arms(scenario.robots)
    arms = {robot: without_environments(arm) for robot, arm in known.items()}
    skills = pipeline_models(scenario, chosen, arms)
    inputs = _inputs(chosen, skills, arms)
    work = unfinished_work("mapping", transfer, chosen, params, held_out, seed, arms, *inputs)

    models = work / "models"
    job = mapping_job(scenario, chosen, params, held_out, seed, skills, models, arms=arms)
    names = load_prior(skills["source"].prior(chosen.task)).layout_names
    arm = known.get(chosen.target)
    external = external_target(chosen.target, arm, chosen.task, chosen.common, names)
    trials = {}
    if not arms or external:
        episodes = read_section(EvaluateParams, "evaluate").episodes
        trials = chain_trials(chosen, skills, models, episodes, external)
    report, chain = train_and_measure(job, trials, work, f"mapping {transfer}")
    if external:
        report["zero_shot"] = chain
    elif chain:
        about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
        of = {role: models.name for role, models in skills.items()}
        write_metrics("chain", transfer, {**about, "skills": of, "zero_shot": chain})
    models_into(Path("models/mapping") / transfer, models)
    write_metrics("mapping", transfer, report)


def _inputs(
    transfer: Transfer, skills: Mapping[Role, RoleModels], arms: Mapping[str, ExternalArm]
) -> list[Path]:
    """The models and the rows of datasets that the mapping is learned from, and no others."""
    models, datasets = [], []
    known: dict[Role, tuple[str, ...]] = {
        "source": (*transfer.common, transfer.task), "target": transfer.common,
    }  # fmt: skip
    for role, tasks in known.items():
        of = skills[role]
        models += [of.vae(), *(of.prior(task) for task in tasks)]
        models += [folder for folder in (of.jacobian(),) if folder]
        datasets += [dataset_of(of.robot, task, arm=arms.get(of.robot)) for task in tasks]
    return [*models, *rows_of(datasets)]


if __name__ == "__main__":
    sys.exit(run_stage(main))
