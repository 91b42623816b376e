"""Stage plain: models of one transfer from plain demonstrations, and their zero-shot links."""

import sys
from typing import Any

from lfr.evaluation.questions import model_trials
from lfr.evaluation.trials import success_rates
from lfr.jobs import run_jobs
from lfr.mapping.models import fit_mapping, mapping_job
from lfr.mapping.training import MappingParams
from lfr.program import run_stage
from lfr.scenarios import Transfer, visible_tasks
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.models import fit_model, model_jobs, model_report, roles_of
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._plain import DATASETS, MODELS, plain_section
from pipeline.paper._spent import Spent
from pipeline.paper._stage import judging, paper_seeds, seeds_into

MODEL_CODE = (
    "lfr.skills", "lfr.mapping", "lfr.models", "lfr.data", "lfr.columns", "lfr.scenarios",
    "lfr.seeds", "lfr.robots", "lfr.tasks",
)  # fmt: skip
LINK_CODE = (
    "lfr.ablations.other_task", "lfr.mapping", "lfr.skills", "lfr.models", "lfr.sim", "lfr.seeds",
    "lfr.robots", "lfr.tasks",
    "lfr.evaluation.chain", "lfr.evaluation.policies", "lfr.evaluation.questions",
    "lfr.evaluation.rollouts", "lfr.evaluation.trials",
)  # fmt: skip
LINKS = ("own_arm", "identity", "recoded", "mapped", "oracle")


def main(transfer: str) -> None:
    """Train models/paper-plain/<transfer>/seed-<n>/{skills,mapping} and judge their links.

    For the seeds of ``questions``. Each model and each link is made as the stages models and
    zero_shot make theirs; parameters and datasets alone differ.
    """
    chosen = transfer_named(transfer)
    seeds = paper_seeds().questions
    runs, spent = _train(chosen, seeds)
    links = _judge(chosen, seeds, judging().episodes)
    about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
    found = {"transfer": transfer, **about, "links": links, "runs": runs}
    spent.write("plain", transfer, found)


def _train(transfer: Transfer, seeds: tuple[int, ...]) -> tuple[list[dict[str, Any]], Spent]:
    """Every seed's models; the same reports as the stage models gives, and the stage's clock."""
    scenario = scenario_named(transfer.scenario)
    skills = plain_section(SkillsParams, "skills")
    mapping = plain_section(MappingParams, "mapping")
    datasets = {
        DATASETS / f"{robot}-{task}"
        for role, robot in roles_of(transfer).items()
        for task in visible_tasks(scenario, robot, role)
    }
    inputs = rows_of(sorted(datasets))
    work = unfinished_work(
        "paper-plain", transfer.name, scenario, skills, mapping, *inputs, code=MODEL_CODE
    )  # fmt: skip
    spent = Spent(work)

    runs, folders = [], {seed: work / f"models/seed-{seed}" for seed in seeds}
    for seed, folder in folders.items():
        title = f"paper plain {transfer.name} seed {seed}"
        jobs, needs = model_jobs(scenario, transfer, skills, seed, folder / "skills", DATASETS)
        fitted = run_jobs(fit_model, jobs, after=needs, work=work, description=title, unit="model")
        phi = mapping_job(
            scenario, transfer, mapping, skills.held_out, seed, folder / "skills",
            folder / "mapping", DATASETS,
        )  # fmt: skip
        (mapped,) = run_jobs(fit_mapping, [phi], work=work, description=title, unit="mapping")
        runs.append({"seed": seed, "skills": model_report(jobs, fitted), "mapping": mapped})
    seeds_into(MODELS / transfer.name, folders)
    return runs, spent


def _judge(
    transfer: Transfer, seeds: tuple[int, ...], episodes: int
) -> dict[str, dict[str, list[Any]]]:
    """The links' success by name, as the stage zero_shot writes it."""
    folder = MODELS / transfer.name
    trials = {
        (seed, name): trial
        for seed in seeds
        for name, trial in model_trials(transfer, folder / f"seed-{seed}", episodes).items()
        if name in LINKS
    }
    # A trial names its policy by content, so that another seed runs its own trials alone.
    work = unfinished_work("paper-plain-links", transfer.name, code=LINK_CODE)
    named = {f"{seed}/{name}": trial for (seed, name), trial in trials.items()}
    success = success_rates(named, work, f"paper plain {transfer.name}")
    links: dict[str, dict[str, list[Any]]] = {}
    for seed, name in trials:
        runs = links.setdefault(name, {"runs": []})["runs"]
        runs.append({"seed": seed, **success[f"{seed}/{name}"]})
    return links


if __name__ == "__main__":
    sys.exit(run_stage(main))
