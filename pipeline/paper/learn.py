"""Stage learn: one method on one transfer, for every reward and seed, judged on held-out starts."""

import csv
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lfr.artifacts import write_whole
from lfr.evaluation.trials import summaries
from lfr.jobs import run_jobs
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from lfr.transfer.methods import method as method_named
from pipeline._stage import unfinished_work
from pipeline.paper._plan import learning
from pipeline.paper._runs import PaperRun, judgements, paper_run, run_part
from pipeline.paper._spent import Spent
from pipeline.paper._stage import POLICIES, judging, paper_seeds

CODE = (
    "lfr.transfer", "lfr.ablations.other_task", "lfr.mapping.artifacts", "lfr.mapping.generator",
    "lfr.models", "lfr.skills.artifacts", "lfr.skills.gaussian", "lfr.skills.prior",
    "lfr.skills.vae", "lfr.sim", "lfr.seeds", "lfr.robots", "lfr.tasks",
    "lfr.evaluation.rollouts", "lfr.evaluation.trials",
)  # fmt: skip


def main(transfer: str, method: str) -> None:
    """Run a method on a transfer; the policies go to models/paper-policies/<transfer>-<method>."""
    chosen = transfer_named(transfer)
    method_named(method)
    plan, judges = learning(), judging()
    name = f"{transfer}-{method}"
    # A run names its models and parameters itself, so another seed runs its own jobs alone.
    work = unfinished_work("paper-learn", name, code=CODE)
    spent = Spent(work)
    runs = [
        paper_run(chosen, method, seed, plan.params_of(method, reward), work)
        for seed in plan.seeds_of(method, paper_seeds())
        for reward in plan.rewards_of(method)
    ]
    first = plan.rewards_of(method)[0]  # where a run starts does not depend on its reward
    shards = [
        (place, trial, shard)
        for place, run in enumerate(runs)
        for trial, shard in judgements(run, judges, zero_shot=run.params.reward == first)
    ]
    waits = {len(runs) + i: place for i, (place, _, _) in enumerate(shards)}
    jobs = [*runs, *(shard for _, _, shard in shards)]
    title = f"paper learn {name}"
    done = run_jobs(run_part, jobs, after=waits, work=work, description=title, unit="part")
    learned, rolled = done[: len(runs)], done[len(runs) :]
    judged = summaries([(place, trial) for place, trial, _ in shards], rolled)

    with write_whole(POLICIES / name) as partial:
        for run in runs:
            shutil.copytree(run.folder / "policy", partial / f"{run.params.reward}-seed-{run.seed}")
    _write_curves(Path("results/paper/learn") / f"{name}.csv", runs, learned)
    about = {
        "transfer": transfer,
        "method": method,
        "robot": chosen.target,
        "task": chosen.task,
        "warm_up": runs[0].params.warm_up,
        "judge": "engine",
        "runs": [
            _summary(run, result, {trial: found for (at, trial), found in judged.items()
                                   if at == place})
            for place, (run, result) in enumerate(zip(runs, learned, strict=True))
        ],
    }  # fmt: skip
    spent.write("learn", name, about)
    for run in runs:  # the replay buffers: large, and of no more use
        shutil.rmtree(run.folder / "checkpoints", ignore_errors=True)


def _write_curves(path: Path, runs: Sequence[PaperRun], learned: Sequence[Any]) -> None:
    rows = [
        {"reward": run.params.reward, "seed": run.seed, **point}
        for run, result in zip(runs, learned, strict=True)
        for point in result["curve"]
    ]
    with write_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _summary(
    run: PaperRun, result: dict[str, Any], judged: dict[str, dict[str, Any]]
) -> dict[str, Any]:
    zero_shot = judged.pop("zero_shot", None)
    counts = {key: result[key] for key in ("env_steps", "updates", "episodes")}
    return {
        "reward": run.params.reward,
        "seed": run.seed,
        **counts,
        "seconds": round(result["seconds"], 1),
        "models": run.models,
        "zero_shot": zero_shot,
        "success": judged,
    }


if __name__ == "__main__":
    sys.exit(run_stage(main))
