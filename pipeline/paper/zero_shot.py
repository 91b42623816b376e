"""Stage zero_shot: what the chain's links and their variants achieve before any RL."""

import sys
from typing import Any

from lfr.evaluation.questions import model_trials, variant_trials
from lfr.evaluation.trials import success_rates
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from pipeline._stage import unfinished_work
from pipeline.paper._spent import Spent
from pipeline.paper._stage import MODELS, VARIANTS, judging, paper_seeds

CODE = (
    "lfr.ablations.other_task", "lfr.mapping", "lfr.skills", "lfr.models", "lfr.sim", "lfr.seeds",
    "lfr.robots", "lfr.tasks",
    "lfr.evaluation.chain", "lfr.evaluation.policies", "lfr.evaluation.questions",
    "lfr.evaluation.rollouts", "lfr.evaluation.trials",
)  # fmt: skip


def main(transfer: str) -> None:
    """Judge every link of a transfer, once for every seed that it has models of."""
    chosen = transfer_named(transfer)
    episodes = judging().episodes
    seeds = paper_seeds()
    models, variants = MODELS / transfer, VARIANTS / transfer

    trials = {}
    for seed in seeds.tables:
        found = model_trials(chosen, models / f"seed-{seed}", episodes)
        trials |= {(seed, name): trial for name, trial in found.items()}
    for seed in seeds.questions:
        own, other = (models / f"seed-{n}" for n in (seed, seeds.after(seed)))
        found = variant_trials(chosen, own, other, variants / f"seed-{seed}", episodes)
        trials |= {(seed, name): trial for name, trial in found.items()}
    # A trial names its policy by content, so that another seed runs its own trials alone.
    work = unfinished_work("paper-zero-shot", transfer, code=CODE)
    spent = Spent(work)
    named = {f"{seed}/{name}": trial for (seed, name), trial in trials.items()}
    success = success_rates(named, work, f"paper zero-shot {transfer}")

    links: dict[str, dict[str, list[Any]]] = {}
    for seed, name in trials:
        runs = links.setdefault(name, {"runs": []})["runs"]
        runs.append({"seed": seed, **success[f"{seed}/{name}"]})
    about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
    spent.write("zero_shot", transfer, {"transfer": transfer, **about, "links": links})


if __name__ == "__main__":
    sys.exit(run_stage(main))
