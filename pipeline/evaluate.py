"""Stage evaluate: a transfer's policies before and after learning, on held-out starts."""

import sys
from pathlib import Path

from lfr.evaluation.protocol import EvaluateParams
from lfr.evaluation.trials import Trial, success_rates
from lfr.params import read_section
from lfr.policies import Pinned
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from lfr.transfer.methods import method as method_named
from lfr.transfer.model import LearnedFiles
from pipeline._stage import SeedParams, unfinished_work, write_metrics


def main(transfer: str, method: str) -> None:
    """Judge the policies of models/transfer/<transfer>-<method>: zero-shot, and trained."""
    chosen = transfer_named(transfer)
    method_named(method)
    params = read_section(EvaluateParams, "evaluate")
    seeds = read_section(SeedParams, "seeds").transfer
    name = f"{transfer}-{method}"
    models = Path("models/transfer") / name
    policies = [models / f"seed-{seed}" for seed in seeds]

    def trial(policy: Path, judge: int) -> Trial:
        files = Pinned.of(LearnedFiles(str(policy)))
        return Trial(files, chosen.target, chosen.task, params.episodes, params.judges[judge])

    trials = {}
    for seed, policy in zip(seeds, policies, strict=True):
        trials[f"{seed}/zero_shot"] = trial(policy / "initial", 0)
        for number, judge in enumerate(params.judges):
            trials[f"{seed}/{judge}"] = trial(policy, number)
    # A trial names its policy by content, so that another seed runs its own trials alone.
    work = unfinished_work("evaluate", name)
    found = success_rates(trials, work, f"evaluate {name}")
    runs = [
        {
            "seed": seed,
            "zero_shot": found[f"{seed}/zero_shot"],
            "success": {judge: found[f"{seed}/{judge}"] for judge in params.judges},
        }
        for seed in seeds
    ]
    about = {"transfer": transfer, "method": method, "judge": params.judges[0], "runs": runs}
    write_metrics("evaluate", name, about)


if __name__ == "__main__":
    sys.exit(run_stage(main))
