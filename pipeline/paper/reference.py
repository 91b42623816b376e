"""Stage reference: SAC from scratch on Panda's Lift against robosuite-benchmark's curve.

paper/robosuite-benchmark-lift-panda.csv holds what github.com/ARISE-Initiative/robosuite-benchmark
(b229f74) measured with rlkit's SAC, under the same controller and dense reward: of each of five
seeds the mean return of 500 steps, every 20 thousand environment steps.
"""

import csv
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lfr.artifacts import file_hash, write_whole
from lfr.jobs import run_jobs
from lfr.program import run_stage
from lfr.scenarios import Transfer
from lfr.scenarios import transfer as transfer_named
from lfr.seeds import episode_seed
from lfr.transfer.actor import SkillActor
from lfr.transfer.environment import RewardRule, RunningEpisode
from lfr.transfer.loop import TransferLoop
from lfr.transfer.methods import start_of
from lfr.transfer.methods.start import TrainedModels
from lfr.transfer.observer import CurvePoint, Observer
from lfr.transfer.params import TransferParams
from lfr.transfer.train import Reported
from pipeline._stage import unfinished_work, write_metrics
from pipeline.paper._plan import learning
from pipeline.paper._stage import MODELS, paper_seeds

CODE = (
    "lfr.transfer", "lfr.ablations.other_task", "lfr.mapping.artifacts", "lfr.mapping.generator",
    "lfr.models", "lfr.skills.artifacts", "lfr.skills.gaussian", "lfr.skills.prior",
    "lfr.skills.vae", "lfr.sim", "lfr.seeds", "lfr.robots", "lfr.tasks",
)  # fmt: skip
TRANSFER = "s1-panda-lift"
STEPS = 100_000  # environment steps of a run
HORIZON = 500  # of the benchmark's episodes
EPISODES = 5  # at each point of the curve, as the benchmark's 2500 steps are
FIRST = 700_000  # of the learning starts: far from those of the runs


@dataclass(frozen=True)
class ReferenceRun:
    """One run of the table's SAC, with longer episodes at the points of its curve.

    Attributes:
        models: folder of the seed's models; SAC takes the units of its inputs from there.
        digest: SHA-256 of them.
    """

    transfer: Transfer
    seed: int
    params: TransferParams
    models: str
    digest: str


def main() -> None:
    """Learn without success ending anything, and write results/paper/reference/lift-panda.csv."""
    chosen = transfer_named(TRANSFER)
    params = replace(learning().params_of("sac", "dense"), steps=STEPS)
    work = unfinished_work("paper-reference", TRANSFER, code=CODE)
    folders = {seed: MODELS / TRANSFER / f"seed-{seed}" for seed in paper_seeds().questions}
    jobs = [
        ReferenceRun(chosen, seed, params, str(folder), file_hash(folder))
        for seed, folder in folders.items()
    ]
    found = run_jobs(follow, jobs, work=work, description="paper reference", unit="run")
    rows = [
        {"seed": job.seed, **row} for job, rows in zip(jobs, found, strict=True) for row in rows
    ]
    out = Path("results/paper/reference/lift-panda.csv")
    with write_whole(out) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    last = [row["mean_return"] for row in rows if row["env_steps"] >= STEPS]
    write_metrics("paper/reference", "lift-panda", {"env_steps": STEPS, "last_returns": last})


def follow(run: ReferenceRun) -> list[dict[str, Any]]:
    """Learn, and at every point of the curve see what 500 steps return."""
    from lfr.sim.simulation import Simulation

    folder, transfer = Path(run.models), run.transfer
    models = TrainedModels(transfer, folder / "skills", folder / "mapping")
    start = start_of("sac", models, run.params, run.seed)
    rows: list[dict[str, Any]] = []

    class Follow(Observer):
        def on_evaluation(self, point: CurvePoint) -> None:
            mean = long_return(start.actor, transfer, run.params)
            rows.append({"env_steps": point.env_steps, "success": point.success,
                         "mean_return": round(mean, 2)})  # fmt: skip

    simulations = [
        Simulation(transfer.target, transfer.task) for _ in range(run.params.simulations)
    ]
    TransferLoop(start, simulations, run.params, run.seed, None, Reported(Follow())).run()
    return rows


def long_return(actor: SkillActor, transfer: Transfer, params: TransferParams) -> float:
    """Mean return of the policy's mean over episodes of the benchmark's length."""
    from lfr.sim.simulation import Simulation

    rule, returns = RewardRule("dense", params.dense_scale), []
    simulation = Simulation(transfer.target, transfer.task)
    simulation.horizon = HORIZON
    for i in range(EPISODES):
        episode = RunningEpisode(simulation)
        episode.start(episode_seed("learning", FIRST + i))
        while not episode.execute(actor.act(episode.observation), rule).over:
            pass
        returns.append(episode.total)
    return float(np.mean(returns))


if __name__ == "__main__":
    sys.exit(run_stage(main))
