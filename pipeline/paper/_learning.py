"""Runs of learning, each judged on held-out starts: what the stages that learn do alike."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lfr.artifacts import write_whole
from lfr.evaluation.trials import summaries
from lfr.jobs import run_jobs
from pipeline.paper._runs import PaperRun, judgements, run_part
from pipeline.paper._spent import Spent
from pipeline.paper._stage import Judging

CODE = (
    "lfr.transfer", "lfr.ablations.other_task", "lfr.mapping.artifacts", "lfr.mapping.generator",
    "lfr.models", "lfr.skills.artifacts", "lfr.skills.gaussian", "lfr.skills.prior",
    "lfr.skills.vae", "lfr.sim", "lfr.seeds", "lfr.robots", "lfr.tasks",
    "lfr.policies", "lfr.evaluation.trials",
)  # fmt: skip


def learn_and_judge(
    stage: str, name: str, runs: Sequence[PaperRun], judging: Judging, policies: Path
) -> None:
    """Learn every run of one method on one transfer, and judge what comes of it.

    Leaves the final policies in ``policies``/<name>, and results/paper/<stage>/<name>.json and
    .csv, its curves.
    """
    work = Path(runs[0].work)
    spent = Spent(work)
    first = runs[0].params.reward  # where a run starts does not depend on its reward
    shards = [
        (place, trial, shard)
        for place, run in enumerate(runs)
        for trial, shard in judgements(run, judging, zero_shot=run.params.reward == first)
    ]
    waits = {len(runs) + i: place for i, (place, _, _) in enumerate(shards)}
    jobs = [*runs, *(shard for _, _, shard in shards)]
    title = f"paper {stage} {name}"
    done = run_jobs(run_part, jobs, after=waits, work=work, description=title, unit="part")
    learned, rolled = done[: len(runs)], done[len(runs) :]
    judged = summaries([(place, trial) for place, trial, _ in shards], rolled)

    with write_whole(policies / name) as partial:
        for run in runs:
            shutil.copytree(run.folder / "policy", partial / f"{run.params.reward}-seed-{run.seed}")
    _write_curves(Path("results/paper") / stage / f"{name}.csv", runs, learned)
    transfer = runs[0].transfer
    about = {
        "transfer": transfer.name,
        "method": runs[0].method,
        "robot": transfer.target,
        "task": transfer.task,
        "warm_up": runs[0].params.warm_up,
        "judge": "engine",
        "runs": [
            _summary(run, result, {trial: found for (at, trial), found in judged.items()
                                   if at == place})
            for place, (run, result) in enumerate(zip(runs, learned, strict=True))
        ],
    }  # fmt: skip
    spent.write(stage, name, about)
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
