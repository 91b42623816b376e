"""Stage evaluate: a transfer's policies before and after learning, on held-out starts."""

import sys
from pathlib import Path

from lfr.evaluation.protocol import EvaluateParams
from lfr.evaluation.trials import JudgeName, Trial, success_rates
from lfr.external import external_arms
from lfr.params import read_section
from lfr.policies import Pinned
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.library import pipeline_models
from lfr.transfer.methods import method as method_named
from lfr.transfer.model import LearnedFiles
from pipeline._runs import target_environment
from pipeline._stage import SeedParams, unfinished_work, write_metrics


def main(transfer: str, method: str) -> None:
    """Judge the policies of models/transfer/<transfer>-<method>: zero-shot, and trained."""
    chosen = transfer_named(transfer)
    method_named(method)
    params = read_section(EvaluateParams, "evaluate")
    seeds = read_section(SeedParams, "seeds").transfer
    name = f"{transfer}-{method}"
    models = Path("models/transfer") / name
    scenario = scenario_named(chosen.scenario)
    arms = external_arms(scenario.robots)
    skills = pipeline_models(scenario, chosen, arms)
    external = target_environment(chosen, skills, arms) if chosen.target in arms else None
    judges: tuple[JudgeName, ...] = ("environment",) if external else params.judges
    policies = [models / f"seed-{seed}" for seed in seeds]

    def trial(policy: Path, judge: JudgeName) -> Trial:
        files = Pinned.of(LearnedFiles(str(policy)))
        return Trial(
            files, chosen.target, chosen.task, params.episodes, judge, external=external
        )  # fmt: skip

    trials = {}
    for seed, policy in zip(seeds, policies, strict=True):
        trials[f"{seed}/zero_shot"] = trial(policy / "initial", judges[0])
        for judge in judges:
            trials[f"{seed}/{judge}"] = trial(policy, judge)
    # A trial names its policy by content, so that another seed runs its own trials alone.
    work = unfinished_work("evaluate", name)
    found = success_rates(trials, work, f"evaluate {name}")
    runs = [
        {
            "seed": seed,
            "zero_shot": found[f"{seed}/zero_shot"],
            "success": {judge: found[f"{seed}/{judge}"] for judge in judges},
        }
        for seed in seeds
    ]
    about = {"transfer": transfer, "method": method, "judge": judges[0], "runs": runs}
    write_metrics("evaluate", name, about)


if __name__ == "__main__":
    sys.exit(run_stage(main))
