"""`python -m studies.evidence`: run what the evidence asks, or what is missing of it."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from lfr.artifacts import code_fingerprint, fingerprint, provenance, work_folder
from lfr.data.dataset import pack_dataset
from lfr.data.log_reader import list_logs
from lfr.demos.recorder import record_demonstrations
from lfr.errors import UnknownNameError
from lfr.jobs import run_jobs
from lfr.program import run_stage
from lfr.scenarios import Scenario, Transfer, visible_tasks
from lfr.skills.library import needed_models, roles_of
from lfr.skills.model_jobs import model_jobs
from studies.evidence.evidence_params import ASKED, Asked, Setting, read_asked
from studies.evidence.repetition import Repetition
from studies.evidence.runs import CURVES, RUNS, CurvePoint, Run, add

# What recordings and skill models depend on; jobs after them name all that they depend on but code.
CODE = (
    "lfr.compiled", "lfr.controllers", "lfr.data", "lfr.demos", "lfr.evaluation.chain",
    "lfr.evaluation.trials", "lfr.mapping", "lfr.networks", "lfr.policies", "lfr.robots", "lfr.sim",
    "lfr.skills", "lfr.spaces", "lfr.tasks", "lfr.transfer", "studies.imitation",
    "studies.learning", "studies.methods", "studies.retargeted", "studies.spirl",
)  # fmt: skip
MADE_BY = provenance()


def main(setting: str = "", asked: str = str(ASKED)) -> None:
    """Run the settings of studies/evidence/evidence.yaml in their order, or the one named.

    Each transfer's runs go to results/evidence/runs.csv, and what was learned on the way to
    curves.csv, once they are done. Finished jobs are kept under work/evidence and are not run
    again; an unfinished run of learning goes on from its checkpoint.
    """
    found = read_asked(Path(asked))
    if setting and setting not in found.settings:
        raise UnknownNameError("setting", setting, found.settings)
    for name in [setting] if setting else found.settings:
        _run_setting(found, name)


def _run_setting(asked: Asked, name: str) -> None:
    setting = asked.settings[name]
    root = _root(asked, setting)
    transfers = asked.transfers(setting)
    _record(asked, setting, transfers, root)
    _train_skills(asked, setting, transfers, root)
    for scenario, transfer in transfers:
        repetitions = [
            Repetition(asked, setting, scenario, transfer, seed, root)
            for seed in range(setting.seeds)
        ]
        measured = [(one, policy) for one in repetitions for policy in one.measured()]
        jobs = {job: None for _, policy in measured for job in policy.jobs}
        needed = {need: None for job in jobs for need in _all_needs(job.needs)}
        done = run_jobs(
            [*needed, *jobs], work=root / "done", description=f"{name} {transfer.name}",
            unit="part",
        )  # fmt: skip
        runs: list[Run] = []
        points: list[CurvePoint] = []
        for one, policy in measured:
            run, curve = one.runs(policy, done, MADE_BY)
            runs.append(run)
            points += curve
        add(Run, RUNS, runs)
        add(CurvePoint, CURVES, points)


def _root(asked: Asked, setting: Setting) -> Path:
    content = code_fingerprint(*CODE), asked.record_params(setting), asked.skills
    return work_folder("evidence", fingerprint(*content))


def _record(
    asked: Asked, setting: Setting, transfers: Iterable[tuple[Scenario, Transfer]], root: Path
) -> None:
    """The demonstrations that are missing, as datasets without pictures."""
    shown = {
        (robot, task): None
        for scenario, transfer in transfers
        for role, robot in roles_of(transfer).items()
        for task in visible_tasks(scenario, robot, role)
    }
    params = asked.record_params(setting)
    for robot, task in shown:
        dataset, logs = root / "datasets" / f"{robot}-{task}", root / "logs" / f"{robot}-{task}"
        if dataset.is_dir():
            continue
        if not logs.is_dir():
            work = root / "recording" / f"{robot}-{task}"
            work.mkdir(parents=True, exist_ok=True)
            record_demonstrations(robot, task, params, logs, work)
        pack_dataset(list_logs(logs), dataset, video=False)


def _train_skills(
    asked: Asked, setting: Setting, transfers: list[tuple[Scenario, Transfer]], root: Path
) -> None:
    """The skill models that a setting needs, each with the priors that any setting needs."""
    everything = asked.all_transfers(setting.demonstrations)
    robots = {robot: None for _, transfer in transfers for robot in roles_of(transfer).values()}
    jobs = []
    for robot in robots:
        asked_for = needed_models(robot, transfers)
        needed = {
            tasks: priors
            for tasks, priors in needed_models(robot, everything).items()
            if tasks in asked_for
        }
        for seed in range(setting.seeds):
            folder = root / f"seed-{seed}" / "skills"
            models = model_jobs(robot, needed, asked.skills, seed, folder, root / "datasets")
            jobs += [job for pair in models.items() for job in pair]
    run_jobs(jobs, work=root / "done", description="skills", unit="model")


def _all_needs(jobs: Iterable) -> Iterable:
    for job in jobs:
        yield from _all_needs(job.needs)
        yield job


if __name__ == "__main__":
    sys.exit(run_stage(main))
