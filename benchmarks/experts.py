"""How often the scripted expert succeeds, on every arm, under every controller, at every task.

    python -m benchmarks.experts [--attempts 50] [--out results/benchmarks]

Attempts are those of the record stage: drifted starts, though not as far, noise, pushes and slips,
recorded labels clean. The same is measured with half the attempts undisturbed (drifted starts
alone), which tells what an arm cannot do from what a slip undoes, and for the arms whose robosuite
models are mended, without the repairs.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks._figures import FOLDER
from lfr.artifacts import provenance, write_json
from lfr.embodiments import embodiment, embodiments
from lfr.evaluation.marked import put
from lfr.jobs import Job, run_jobs
from lfr.params import read_section
from lfr.robots import ROBOTS
from lfr.robots.repair import Repair
from lfr.tasks import TASKS

PAGE, MARKER = Path("docs/simulation.md"), "experts"
"""Where `table` is shown."""
DRIFT = 48
"""Steps, half of the main job's: from further away it is not the hand that decides."""

Condition = Literal["recorded", "undisturbed", "unrepaired"]


@dataclass(frozen=True)
class Trial:
    """``attempts`` of the expert on an embodiment at a task."""

    name: str
    task: str
    attempts: int
    condition: Condition = "recorded"


def trials(attempts: int) -> list[Trial]:
    """What is recorded, the same undisturbed, and what repairs change under OSC_POSE."""
    every, half = [body.name for body in embodiments()], max(1, attempts // 2)
    broken = [r.name for r in ROBOTS.values() if r.repairs != Repair()]
    return [
        Trial(name, task, attempts if condition == "recorded" else half, condition)
        for names, condition in (
            (every, "recorded"),
            (every, "undisturbed"),
            (broken, "unrepaired"),
        )
        for name in names
        for task in TASKS
    ]


def run_trial(trial: Trial) -> dict[str, Any]:
    """Successes, and control steps to the end of a successful attempt."""
    from lfr.demos.attempt import attempt
    from lfr.demos.recorder import RecordParams
    from lfr.seeds import episode_seed
    from lfr.sim.simulation import Simulation

    if trial.condition == "unrepaired":
        _break(trial.name)
    simulation, lengths = Simulation(trial.name, trial.task), []
    params = read_section(RecordParams, "record").attempt
    params = replace(params, drift=replace(params.drift, steps=DRIFT))
    if trial.condition == "undisturbed":
        quiet = replace(params.expert, noise=0.0, perturbation=0.0, slip=0.0)
        params = replace(params, expert=quiet)
    for index in range(trial.attempts):
        moments = list(attempt(simulation, params, episode_seed("demonstration", index)))
        if any(moment.success for moment in moments):
            lengths.append(len(moments))
    return {
        "embodiment": trial.name,
        "task": trial.task,
        "condition": trial.condition,
        "attempts": trial.attempts,
        "successes": len(lengths),
        "median_steps": float(np.median(lengths)) if lengths else None,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Percent of attempts that succeed, recorded / undisturbed (unrepaired), as Markdown."""
    cells = {
        (row["embodiment"], row["task"], row["condition"]): round(
            100 * row["successes"] / row["attempts"]
        )
        for row in rows
    }

    def cell(name: str, task: str) -> str:
        unrepaired = cells.get((name, task, "unrepaired"))
        text = f"{cells[name, task, 'recorded']} / {cells[name, task, 'undisturbed']}"
        return text if unrepaired is None else f"{text} ({unrepaired})"

    names = dict.fromkeys(row["embodiment"] for row in rows)
    lines = [f"| `{name}` | {' | '.join(cell(name, task) for task in TASKS)} |" for name in names]
    head = f"| | {' | '.join(task.stock_name for task in TASKS.values())} |"
    return "\n".join([head, "|---" * (len(TASKS) + 1) + "|", *lines])


def _break(name: str) -> None:
    """In this process, the arm as robosuite has it."""
    from lfr.sim import scene_cache, simulation

    robot = ROBOTS[name]
    gripper = replace(robot.gripper, repair=Repair(), speed=robot.gripper.stock_speed)
    ROBOTS[name] = replace(robot, repair=Repair(), gripper=gripper)
    embodiment.cache_clear()
    simulation._scene.cache_clear()
    scene_cache.scene_folder = lambda: None  # pyright: ignore[reportAttributeAccessIssue]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--attempts", type=int, default=50)
    parser.add_argument("--only", help="one arm, printed alone")
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    every = trials(arguments.attempts)
    if arguments.only:
        every = [trial for trial in every if trial.name.split("-")[0] == arguments.only]
    jobs = [Job(run_trial, trial) for trial in every if trial.condition != "unrepaired"]
    rows = list(run_jobs(jobs, description="experts", unit="trial").values())
    # One after the other in this process, which has no other arm's trials to come.
    rows += [run_trial(trial) for trial in every if trial.condition == "unrepaired"]
    for row in rows:
        print(
            f"{row['embodiment']:32s}{row['task']:14s}{row['successes']:3d} of {row['attempts']}"
            f"  {row['condition']}"
        )
    if not arguments.only:
        path = arguments.out / "experts.json"
        write_json(path, {"trials": rows, "made_with": provenance()})
        print(path)
        if arguments.out == FOLDER:
            put(PAGE, MARKER, table(rows))
            print(PAGE)


if __name__ == "__main__":
    main()
