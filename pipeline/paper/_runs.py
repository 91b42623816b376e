"""One run of a method, and the judgement of what it has learned, as jobs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import file_hash, fingerprint
from lfr.evaluation.trials import Trial, run_trial, shards_of
from lfr.scenarios import Transfer
from lfr.transfer.methods import VARIANTS as NEEDED
from lfr.transfer.methods import start_of
from lfr.transfer.methods.start import TrainedModels
from lfr.transfer.model import LearnedFiles, save_policy
from lfr.transfer.params import TransferParams
from lfr.transfer.train import train
from pipeline.paper._stage import MODELS, VARIANTS, Judging


@dataclass(frozen=True)
class PaperRun:
    """One method on one transfer by one reward and seed.

    Attributes:
        seed: of the models and of the run.
        models: SHA-256 of all that it may start from, so that other models make another run.
        root: where the models lie, by transfer and seed.
        work: folder of the stage's unfinished work.
    """

    transfer: Transfer
    method: str
    seed: int
    params: TransferParams
    models: str
    root: str
    work: str

    @property
    def folder(self) -> Path:
        """What the run leaves: the policies ``initial`` and ``policy``, and its checkpoints."""
        name = f"{self.params.reward}-seed-{self.seed}"
        return Path(self.work) / f"{name}-{fingerprint(self.params, self.models)}"


def paper_run(
    transfer: Transfer,
    method: str,
    seed: int,
    params: TransferParams,
    work: Path,
    root: Path = MODELS,
) -> PaperRun:
    """The run for the models as they are: those of its seed, and the variant that it needs."""
    folders = [root / transfer.name / f"seed-{seed}"]
    if method in NEEDED:
        folders.append(VARIANTS / transfer.name / f"seed-{seed}" / NEEDED[method])
    digest = fingerprint(*(file_hash(folder) for folder in folders))
    return PaperRun(transfer, method, seed, params, digest, str(root), str(work))


def judgements(run: PaperRun, judging: Judging, *, zero_shot: bool) -> list[tuple[str, Trial]]:
    """The shards of all trials of a run, each with what it says: "zero_shot", or the judge."""
    robot, task = run.transfer.target, run.transfer.task
    final = LearnedFiles(str(run.folder / "policy"))
    trials = {
        "engine": Trial(final, robot, task, judging.episodes),
        "robosuite": Trial(final, robot, task, judging.stock_episodes, "robosuite"),
    }
    if zero_shot:
        initial = LearnedFiles(str(run.folder / "initial"))
        trials["zero_shot"] = Trial(initial, robot, task, judging.episodes)
    return [(name, shard) for name, trial in trials.items() for shard in shards_of(trial)]


def run_part(part: PaperRun | Trial) -> Any:
    """A run, or a shard of a trial."""
    return learn(part) if isinstance(part, PaperRun) else run_trial(part)


def learn(run: PaperRun) -> dict[str, Any]:
    """Run it, or go on where it was killed; what `lfr.transfer.train.train` says of it."""
    transfer, folder = run.transfer, run.folder
    skills, mapping, variants = (
        root / transfer.name / f"seed-{run.seed}" / part
        for root, part in ((Path(run.root), "skills"), (Path(run.root), "mapping"), (VARIANTS, ""))
    )
    models = TrainedModels(transfer, skills, mapping, variants)
    start = start_of(run.method, models, run.params, run.seed)
    about = {"transfer": transfer.name, "method": run.method}
    described = {"robot": transfer.target, "task": transfer.task, "seed": run.seed}
    save_policy(folder / "initial", start.actor, {**described, **about})
    return train(
        start, transfer.target, transfer.task, run.params, run.seed,
        out=folder / "policy", work=folder / "checkpoints", about=about,
    )  # fmt: skip
