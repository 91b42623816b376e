"""Stage reference: SAC from scratch on Panda's Lift against robosuite-benchmark's curve.

paper/robosuite-benchmark-lift-panda.csv holds what github.com/ARISE-Initiative/robosuite-benchmark
(b229f74) measured with rlkit's SAC, under the same controller and dense reward: of each of five
seeds the mean return of 500 steps, every 20 thousand environment steps.
"""

import csv
import shutil
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lfr.artifacts import file_hash, fingerprint, read_json, write_json, write_whole
from lfr.errors import ParameterError
from lfr.jobs import run_jobs
from lfr.params import from_mapping, read_yaml
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
from pipeline._stage import unfinished_work
from pipeline.paper._plan import learning
from pipeline.paper._spent import Spent
from pipeline.paper._stage import MODELS, PARAMS, paper_seeds

CODE = (
    "lfr.transfer", "lfr.ablations.other_task", "lfr.mapping.artifacts", "lfr.mapping.generator",
    "lfr.models", "lfr.skills.artifacts", "lfr.skills.gaussian", "lfr.skills.prior",
    "lfr.skills.vae", "lfr.sim", "lfr.seeds", "lfr.robots", "lfr.tasks",
)  # fmt: skip
TRANSFER = "s1-panda-lift"
FIRST = 700_000  # of the learning starts: far from those of the runs


@dataclass(frozen=True)
class ReferenceParams:
    """Section ``reference``, which may be missing; horizon and episodes are the benchmark's."""

    steps: int = 100_000  # environment steps of a run
    horizon: int = 500  # control steps of the episodes that are compared
    episodes: int = 5  # at each point of the curve: the benchmark's 2500 steps

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value < 1:
                raise ParameterError(f"{name} must be at least 1, found {value}")


@dataclass(frozen=True)
class ReferenceRun:
    """One run of the table's SAC, with longer episodes at the points of its curve.

    Attributes:
        params: of learning, for as many steps as the reference's.
        models: folder of the seed's models; SAC takes the units of its inputs from there.
        digest: SHA-256 of them.
        work: folder of the stage's unfinished work.
    """

    transfer: Transfer
    seed: int
    params: TransferParams
    reference: ReferenceParams
    models: str
    digest: str
    work: str

    @property
    def folder(self) -> Path:
        """Of the checkpoints, and of the rows so far."""
        content = fingerprint(self.params, self.reference, self.digest)
        return Path(self.work) / f"seed-{self.seed}-{content}"


def main() -> None:
    """Learn without success ending anything, and write results/paper/reference/lift-panda.csv."""
    chosen = transfer_named(TRANSFER)
    where = f"{PARAMS}: reference"
    wanted = from_mapping(ReferenceParams, read_yaml(PARAMS).get("reference", {}), where)
    params = replace(learning().params_of("sac", "dense"), steps=wanted.steps)
    work = unfinished_work("paper-reference", TRANSFER, code=CODE)
    spent = Spent(work)
    folders = {seed: MODELS / TRANSFER / f"seed-{seed}" for seed in paper_seeds().questions}
    jobs = [
        ReferenceRun(chosen, seed, params, wanted, str(folder), file_hash(folder), str(work))
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
    last = [row["mean_return"] for row in rows if row["env_steps"] >= wanted.steps]
    about = {"env_steps": wanted.steps, "last_returns": last}
    spent.write("reference", "lift-panda", about)
    for job in jobs:  # the replay buffers: large, and of no more use
        shutil.rmtree(job.folder, ignore_errors=True)


def follow(run: ReferenceRun) -> list[dict[str, Any]]:
    """Learn, and at every point of the curve see what long episodes return.

    Killed, it goes on from the last checkpoint; what it had seen after that is seen again.
    """
    from lfr.sim.simulation import Simulation

    folder, transfer = Path(run.models), run.transfer
    models = TrainedModels(transfer, folder / "skills", folder / "mapping")
    start = start_of("sac", models, run.params, run.seed)
    seen = run.folder / "rows.json"

    class Follow(Observer):
        def on_evaluation(self, point: CurvePoint) -> None:
            before = read_json(seen) if seen.is_file() else []
            rows = [row for row in before if row["env_steps"] < point.env_steps]
            mean = long_return(start.actor, run)
            rows.append({"env_steps": point.env_steps, "success": point.success,
                         "mean_return": round(mean, 2)})  # fmt: skip
            write_json(seen, rows)

    simulations = [
        Simulation(transfer.target, transfer.task) for _ in range(run.params.simulations)
    ]
    observer, checkpoints = Reported(Follow()), run.folder / "checkpoints"
    TransferLoop(start, simulations, run.params, run.seed, checkpoints, observer).run()
    return read_json(seen)


def long_return(actor: SkillActor, run: ReferenceRun) -> float:
    """Mean return of the policy's mean over episodes as long as the benchmark's, unscaled."""
    from lfr.sim.simulation import Simulation

    rule, returns = RewardRule("dense", 1.0), []
    simulation = Simulation(run.transfer.target, run.transfer.task)
    simulation.horizon = run.reference.horizon
    for i in range(run.reference.episodes):
        episode = RunningEpisode(simulation)
        episode.start(episode_seed("learning", FIRST + i))
        while not episode.execute(actor.act(episode.observation), rule).over:
            pass
        returns.append(episode.total)
    return float(np.mean(returns))


if __name__ == "__main__":
    sys.exit(run_stage(main))
