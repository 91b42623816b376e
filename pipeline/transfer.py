"""Stage transfer: one method brings a new task to the target by learning there (Algorithm 2)."""

import csv
import shutil
import sys
from pathlib import Path
from typing import Any

from lfr.artifacts import write_whole
from lfr.external import external_arms
from lfr.jobs import Job, run_jobs
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.library import pipeline_models
from lfr.skills.saved_models import load_seen
from lfr.transfer.methods import method as method_named
from lfr.transfer.transfer_params import TransferParams
from pipeline._runs import RunJob, learn, target_environment
from pipeline._stage import SeedParams, unfinished_work, write_metrics


def main(transfer: str, method: str) -> None:
    """Train models/transfer/<transfer>-<method>/seed-<n>, one run for each of seeds.transfer.

    The course of each run goes to models/learning/<transfer>-<method>/seed-<n>.
    """
    chosen = transfer_named(transfer)
    method_named(method)
    params = read_section(TransferParams, "transfer")
    seeds = read_section(SeedParams, "seeds").transfer
    name = f"{transfer}-{method}"
    scenario = scenario_named(chosen.scenario)
    arms = external_arms(scenario.robots)
    skills = pipeline_models(scenario, chosen, arms)
    external = target_environment(chosen, skills, arms)
    source, target, mapping = skills["source"], skills["target"], Path("models/mapping") / transfer
    models = source.vae(), source.prior(chosen.task), target.vae(), mapping
    work = unfinished_work("transfer", name, chosen, params, external, *models)

    folders = {seed: work / f"seed-{seed}" for seed in seeds}
    jobs = [
        Job(
            learn,
            RunJob(chosen, method, seed, params, str(folder), skills, str(mapping), external),
        )
        for seed, folder in folders.items()
    ]
    done = run_jobs(jobs, work=work, description=f"transfer {name}", unit="run")
    runs = list(done.values())

    with write_whole(Path("models/transfer") / name) as partial:
        for seed, folder in folders.items():
            shutil.copytree(folder / "policy", partial / f"seed-{seed}")
            shutil.copytree(folder / "initial", partial / f"seed-{seed}" / "initial")
    with write_whole(Path("models/learning") / name) as partial:
        for seed, folder in folders.items():
            shutil.copytree(folder / "learning", partial / f"seed-{seed}")
    _write_curves(Path("results/transfer") / f"{name}.csv", runs)
    seen = load_seen(source.vae()), load_seen(target.vae())
    about = {
        "transfer": transfer,
        "method": method,
        "robot": chosen.target,
        "task": chosen.task,
        "reward": params.reward,
        "warm_up": params.warm_up,
        "runs": [_summary(run) for run in runs],
        "datasets": seen[0].datasets | seen[1].datasets,
    }
    write_metrics("transfer", name, about)
    for folder in folders.values():  # the replay buffers: large, and of no more use
        shutil.rmtree(folder / "checkpoints", ignore_errors=True)


def _write_curves(path: Path, runs: list[dict[str, Any]]) -> None:
    rows = [{"seed": run["seed"], **point} for run in runs for point in run["curve"]]
    with write_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _summary(run: dict[str, Any]) -> dict[str, Any]:
    counts = {key: run[key] for key in ("seed", "env_steps", "updates", "episodes")}
    first, last = (run["curve"][i]["success"] for i in (0, -1))
    return {**counts, "learning_success_first": first, "learning_success_last": last,
            "seconds": round(run["seconds"], 1)}  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_stage(main))
