"""Stage models: skill models and mapping of one transfer, once for every seed."""

import sys
from typing import Any

from lfr.jobs import run_jobs
from lfr.mapping.models import fit_mapping, mapping_job
from lfr.mapping.training import MappingParams
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.scenarios import visible_tasks
from lfr.skills.demonstrations import DATASETS
from lfr.skills.models import fit_model, model_jobs, model_report, roles_of
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._spent import Spent
from pipeline.paper._stage import MODELS, paper_seeds, seeds_into

CODE = (
    "lfr.skills", "lfr.mapping", "lfr.models", "lfr.data", "lfr.columns", "lfr.scenarios",
    "lfr.seeds", "lfr.robots", "lfr.tasks",
)  # fmt: skip


def main(transfer: str) -> None:
    """Train models/paper/<transfer>/seed-<n>/{skills,mapping} as the main job trains its own."""
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    skills = read_section(SkillsParams, "skills")
    mapping = read_section(MappingParams, "mapping")
    datasets = {
        DATASETS / f"{robot}-{task}"
        for role, robot in roles_of(chosen).items()
        for task in visible_tasks(scenario, robot, role)
    }
    inputs = rows_of(sorted(datasets))
    work = unfinished_work(
        "paper-models", transfer, scenario, skills, mapping, *inputs, code=CODE
    )  # fmt: skip
    spent = Spent(work)
    models = work / "models"
    folders = {seed: models / f"seed-{seed}" for seed in paper_seeds().tables}

    trained: list[Any] = []
    places: dict[int, slice] = {}
    needs: dict[int, int] = {}
    for seed, folder in folders.items():
        jobs, before = model_jobs(scenario, chosen, skills, seed, folder / "skills")
        first = len(trained)
        needs |= {first + place: first + vae for place, vae in before.items()}
        trained += jobs
        places[seed] = slice(first, len(trained))
    title = f"paper models {transfer}"
    fitted = run_jobs(fit_model, trained, after=needs, work=work, description=title, unit="model")
    mappings = [
        mapping_job(
            scenario, chosen, mapping, skills.held_out, seed, folder / "skills", folder / "mapping"
        )
        for seed, folder in folders.items()
    ]
    mapped = run_jobs(fit_mapping, mappings, work=work, description=title, unit="mapping")

    seeds_into(MODELS / transfer, folders)
    runs = [
        {"seed": seed, "skills": model_report(trained[place], fitted[place]), "mapping": report}
        for (seed, place), report in zip(places.items(), mapped, strict=True)
    ]
    spent.write("models", transfer, {"runs": runs})


if __name__ == "__main__":
    sys.exit(run_stage(main))
