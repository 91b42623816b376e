"""Stage variants: other phi, other VAEs and other priors of one transfer, for some of the seeds."""

import sys
from pathlib import Path

from lfr.ablations.variants import fit_variant, variant_jobs
from lfr.artifacts import fingerprint
from lfr.jobs import run_jobs
from lfr.mapping.training import MappingParams
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.demonstrations import DATASETS
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._spent import Spent
from pipeline.paper._stage import MODELS, VARIANTS, paper_seeds, seeds_into

CODE = (
    "lfr.ablations", "lfr.skills", "lfr.mapping", "lfr.models", "lfr.data", "lfr.columns",
    "lfr.scenarios", "lfr.seeds", "lfr.robots", "lfr.tasks", "lfr.sim.layout",
)  # fmt: skip


def main(transfer: str) -> None:
    """Train models/paper-variants/<transfer>/seed-<n>/<variant> beside models/paper/<transfer>."""
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    skills = read_section(SkillsParams, "skills")
    mapping = read_section(MappingParams, "mapping")
    seeds = paper_seeds()
    models = {seed: MODELS / transfer / f"seed-{seed}" / "skills" for seed in seeds.tables}
    shown = {(chosen.source, task) for task in (*chosen.common, chosen.task)}
    shown |= {(chosen.target, task) for task in chosen.common}
    inputs = rows_of(DATASETS / f"{robot}-{task}" for robot, task in sorted(shown))
    work = unfinished_work(
        "paper-variants", transfer, scenario, skills, mapping, *inputs, code=CODE
    )
    spent = Spent(work)

    def folder(seed: int) -> Path:
        """Named after the models that the seed's variants start from, so that others start anew."""
        content = fingerprint(models[seed], models[seeds.after(seed)])
        return work / "models" / f"seed-{seed}-{content}"

    folders = {seed: folder(seed) for seed in seeds.questions}
    jobs = {
        (seed, name): job
        for seed, out in folders.items()
        for name, job in variant_jobs(
            scenario, chosen, skills, mapping, seed, models[seed], models[seeds.after(seed)], out
        ).items()
    }
    title = f"paper variants {transfer}"
    done = run_jobs(
        fit_variant, list(jobs.values()), work=work, description=title, unit="variant"
    )  # fmt: skip
    seeds_into(VARIANTS / transfer, folders)
    found = dict(zip(jobs, done, strict=True))
    runs = [
        {"seed": seed, "variants": {name: one for (of, name), one in found.items() if of == seed}}
        for seed in seeds.questions
    ]
    spent.write("variants", transfer, {"runs": runs})


if __name__ == "__main__":
    sys.exit(run_stage(main))
