"""Stage zero_shot: what the chain's links and their variants achieve before any RL."""

import sys

from lfr.evaluation.questions import model_trials, variant_trials
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from pipeline._stage import unfinished_work
from pipeline.paper._links import CODE, judged_links
from pipeline.paper._spent import Spent
from pipeline.paper._stage import MODELS, VARIANTS, judging, paper_seeds


def main(transfer: str) -> None:
    """Judge every link of a transfer, once for every seed that it has models of."""
    chosen = transfer_named(transfer)
    episodes = judging().episodes
    seeds = paper_seeds()
    models, variants = MODELS / transfer, VARIANTS / transfer

    work = unfinished_work("paper-zero-shot", transfer, code=CODE)
    spent = Spent(work)
    trials = {}
    for seed in seeds.tables:
        found = model_trials(chosen, models / f"seed-{seed}", episodes)
        trials |= {(seed, name): trial for name, trial in found.items()}
    for seed in seeds.questions:
        own, other = (models / f"seed-{n}" for n in (seed, seeds.after(seed)))
        found = variant_trials(chosen, own, other, variants / f"seed-{seed}", episodes)
        trials |= {(seed, name): trial for name, trial in found.items()}
    links = judged_links(trials, work, f"paper zero-shot {transfer}")
    about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
    spent.write("zero_shot", transfer, {"transfer": transfer, **about, "links": links})


if __name__ == "__main__":
    sys.exit(run_stage(main))
