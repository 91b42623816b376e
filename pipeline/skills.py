"""Stage skills: the skill VAEs and priors of one robot that any transfer needs."""

import shutil
import sys
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.embodiments import embodiment
from lfr.evaluation.own_arm import train_and_measure
from lfr.evaluation.protocol import EvaluateParams
from lfr.external import external, external_arms, without_environments
from lfr.params import read_names, read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.compatible import check_arms
from lfr.skills.demonstrations import dataset_of
from lfr.skills.library import needed_models, skills_root
from lfr.skills.model_jobs import ModelJobs, model_jobs
from lfr.skills.skill_params import SkillsParams
from pipeline._stage import SeedParams, rows_of, unfinished_work, write_metrics


def main(robot: str) -> None:
    """Train the skill models of a robot that the transfers of params.yaml need.

    They go to models/skills/<robot>, those of an arm that is not simulated to
    models/external-skills/<robot>, and of their priors' success nothing is said but of tasks that
    have an environment.
    """
    arm = external_arms([robot]).get(robot)
    if arm is None:
        embodiment(robot)
    params = read_section(SkillsParams, "skills")
    seed = read_section(SeedParams, "seeds").models
    transfers = [transfer_named(name) for name in (*read_names("transfers"), *external().transfers)]
    scenarios = [scenario_named(transfer.scenario) for transfer in transfers]
    for scenario in scenarios:
        if robot in scenario.robots:
            check_arms(scenario, external_arms(scenario.robots))
    needed = needed_models(robot, zip(scenarios, transfers, strict=True))
    datasets = {dataset_of(robot, task, arm=arm) for tasks in needed for task in tasks}
    # Not `needed` itself: another transfer trains what it needs beyond the others.
    inputs = rows_of(sorted(datasets))
    trained = without_environments(arm) if arm else None
    work = unfinished_work("skills", robot, params, seed, trained, *inputs)

    jobs = model_jobs(robot, needed, params, seed, work / "models", arm=trained)
    episodes = read_section(EvaluateParams, "evaluate").episodes
    report = train_and_measure(jobs, episodes, work, f"skills {robot}", arm)
    _gather(jobs, work / "models" / robot, skills_root(robot, [robot] if arm else []) / robot)
    write_metrics("skills", robot, {"robot": robot, "models": report})


def _gather(jobs: ModelJobs, models: Path, out: Path) -> None:
    """Copy the models of these jobs, and of none that were needed once, out of the work folder."""
    with write_whole(out) as partial:
        partial.mkdir()
        for vae, priors in jobs.items():
            folder = vae.spec.models
            made = [folder.vae, *map(folder.prior, priors.spec.tasks)]
            made += [folder.jacobian] if folder.jacobian.is_dir() else []
            for model in made:
                shutil.copytree(model, partial / model.relative_to(models))


if __name__ == "__main__":
    sys.exit(run_stage(main))
