"""Stage mapping: G and F of one transfer, and the chain of zero-shot success around them."""

import sys
from pathlib import Path

from lfr.evaluation.chain import chain_trials, train_and_measure
from lfr.evaluation.protocol import EvaluateParams
from lfr.external import external_arms
from lfr.mapping.models import mapping_job
from lfr.mapping.training import MappingParams
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.demonstrations import DATASETS
from lfr.skills.params import SkillsParams
from pipeline._stage import SeedParams, models_into, rows_of, unfinished_work, write_metrics


def main(transfer: str) -> None:
    """Train a transfer's mapping into models/mapping/<transfer> and measure its chain.

    The chain is left out where an arm is not simulated.
    """
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    params = read_section(MappingParams, "mapping")
    held_out = read_section(SkillsParams, "skills").held_out
    seed = read_section(SeedParams, "seeds").models
    skills = Path("models/skills") / transfer
    arms = external_arms(scenario.robots)
    datasets = [
        arms[robot].dataset(task) if robot in arms else DATASETS / f"{robot}-{task}"
        for robot, tasks in (
            (chosen.source, (*chosen.common, chosen.task)),
            (chosen.target, chosen.common),
        )
        for task in tasks
    ]
    inputs = rows_of(datasets)
    work = unfinished_work(
        "mapping", transfer, chosen, params, held_out, seed, skills, arms, *inputs
    )

    models = work / "models"
    job = mapping_job(scenario, chosen, params, held_out, seed, skills, models, arms=arms)
    trials = {}
    if not arms:
        episodes = read_section(EvaluateParams, "evaluate").episodes
        trials = chain_trials(chosen, skills, models, episodes)
    report, chain = train_and_measure(job, trials, work, f"mapping {transfer}")
    if chain:
        about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
        write_metrics("chain", transfer, {**about, "zero_shot": chain})
    models_into(Path("models/mapping") / transfer, models)
    write_metrics("mapping", transfer, report)


if __name__ == "__main__":
    sys.exit(run_stage(main))
