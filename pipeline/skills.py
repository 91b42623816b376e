"""Stage skills: the skill VAEs and priors of one transfer's source, target and oracle."""

import sys
from pathlib import Path

from lfr.evaluation.own_arm import train_and_measure
from lfr.evaluation.protocol import EvaluateParams
from lfr.external import external_arms
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.scenarios import visible_tasks
from lfr.skills.compatible import check_arms
from lfr.skills.demonstrations import DATASETS
from lfr.skills.models import model_jobs, roles_of
from lfr.skills.params import SkillsParams
from pipeline._stage import SeedParams, models_into, rows_of, unfinished_work, write_metrics


def main(transfer: str) -> None:
    """Train the skill models that a transfer needs into models/skills/<transfer>.

    Without a simulation of both arms nothing is said of the priors' success.
    """
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    params = read_section(SkillsParams, "skills")
    seed = read_section(SeedParams, "seeds").models
    arms = external_arms(scenario.robots)
    check_arms(scenario, arms)
    datasets = {
        arms[robot].dataset(task) if robot in arms else DATASETS / f"{robot}-{task}"
        for role, robot in roles_of(chosen).items()
        for task in visible_tasks(scenario, robot, role)
    }
    inputs = rows_of(sorted(datasets))
    work = unfinished_work("skills", transfer, scenario, params, seed, arms, *inputs)

    jobs = model_jobs(scenario, chosen, params, seed, work / "models", arms=arms)
    episodes = 0 if arms else read_section(EvaluateParams, "evaluate").episodes
    report = train_and_measure(jobs, episodes, work, f"skills {transfer}")
    models_into(Path("models/skills") / transfer, work / "models")
    write_metrics("skills", transfer, report)


if __name__ == "__main__":
    sys.exit(run_stage(main))
