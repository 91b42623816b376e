r"""How much a mapping's own seed matters: zero-shot success of several G on learning starts.

    python -m pipeline._mapping_seeds --transfer s2-sawyer-pick_place \
        --share 0.25 0.5 --seed -1 1 2 3 4

Data and skill models are those of `dvc repro`, and stay the same; each G is trained as the stage
trains it, but for its seed and `mapping.posterior_share`, and tried on starts that are not held
out. Seed -1 is the main job's own. Writes results/studies/mapping-seeds-<transfer>.json.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lfr.artifacts import fingerprint, provenance, write_json
from lfr.evaluation.statistics import success_of
from lfr.jobs import run_jobs
from lfr.mapping.models import MappingJob, mapping_job, read_material
from lfr.mapping.training import MappingParams, train_mapping
from lfr.params import read_section
from lfr.policies import roll_out
from lfr.scenarios import scenario, transfer
from lfr.seeds import episode_seed
from lfr.skills.artifacts import load_vae
from lfr.skills.params import SkillsParams
from lfr.skills.policy import SkillPolicy
from pipeline._stage import SeedParams

FIRST = 500_000  # of the learning starts: far from those that transfer learning uses
OWN = -1


@dataclass(frozen=True)
class Try:
    """One G: the stage's job, the seed of its training, and how often it is tried."""

    job: MappingJob
    seed: int
    episodes: int


def run_try(one: Try) -> dict[str, Any]:
    """Train G and roll the source's prior of the new task out on the target through it."""
    from lfr.sim.simulation import simulation

    skills = Path(one.job.skills)
    vaes = load_vae(skills / "source" / "vae"), load_vae(skills / "target" / "vae")
    own = int(fingerprint(one.job.transfer.name, one.job.seed), 16) % 2**31  # as `fit_mapping`
    seed = own if one.seed == OWN else one.seed
    known = read_material(one.job, seed)
    tasks = list(known.training.values())
    g, _ = train_mapping(tasks, vaes, known.windows, one.job.params, seed)
    starts = [episode_seed("learning", FIRST + i) for i in range(one.episodes)]
    arm = simulation(one.job.transfer.target, one.job.transfer.task)
    outcomes = roll_out(SkillPolicy(known.new[0], g, vaes[1]), arm, starts)
    success = success_of(sum(outcome.success for outcome in outcomes), one.episodes)
    share = one.job.params.posterior_share
    return {"posterior_share": share, "seed": one.seed, **vars(success)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--transfer", required=True)
    parser.add_argument("--share", type=float, nargs="+", required=True)
    parser.add_argument("--seed", type=int, nargs="+", required=True)
    parser.add_argument("--episodes", type=int, default=60)
    options = parser.parse_args()
    chosen = transfer(options.transfer)
    params = read_section(MappingParams, "mapping")
    held_out = read_section(SkillsParams, "skills").held_out
    models = read_section(SeedParams, "seeds").models
    skills = Path("models/skills") / chosen.name
    tries = [
        Try(
            mapping_job(
                scenario(chosen.scenario), chosen, replace(params, posterior_share=share),
                held_out, models, skills, Path("work"),
            ), seed, options.episodes,
        )
        for share in options.share for seed in options.seed
    ]  # fmt: skip
    found = run_jobs(run_try, tries, description=f"seeds of G: {chosen.name}", unit="G")
    out = Path("results/studies") / f"mapping-seeds-{chosen.name}.json"
    write_json(out, {"tries": found, "made_with": provenance()})
    print(out)


if __name__ == "__main__":
    main()
