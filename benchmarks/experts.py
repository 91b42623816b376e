"""How often the scripted expert succeeds, on every arm, under every controller, at every task.

    python -m benchmarks.experts [--attempts 50] [--out results/benchmarks]

Attempts are those of the record stage: drifted starts, noise, pushes and slips, recorded labels
clean. For the arms whose robosuite models are mended, the same is measured without the repairs.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._figures import FOLDER
from lfr.artifacts import provenance, write_json
from lfr.embodiments import embodiment, embodiments
from lfr.jobs import Job, run_jobs
from lfr.params import read_section
from lfr.robots.repair import Repair
from lfr.tasks import TASKS

PAGE = Path("docs/simulation.md")
BEGIN, END = "<!-- experts -->", "<!-- /experts -->"
"""Between these the page shows `table`."""


@dataclass(frozen=True)
class Trial:
    """``attempts`` of the expert on an embodiment at a task, with or without the arm's repairs."""

    name: str
    task: str
    attempts: int
    repaired: bool = True


def trials(attempts: int) -> list[Trial]:
    """Everything repaired, then what repairs change under the default controller."""
    every = [Trial(body.name, task, attempts) for body in embodiments() for task in TASKS]
    broken = [body.name for body in embodiments() if body.robot.repairs != Repair()]
    default = [name for name in broken if embodiment(name).robot.name == name]
    return every + [
        Trial(name, task, max(1, attempts // 2), repaired=False)
        for name in default
        for task in TASKS
    ]


def run_trial(trial: Trial) -> dict[str, Any]:
    """Successes, and control steps to the end of a successful attempt."""
    from lfr.demos.attempt import attempt
    from lfr.demos.recorder import RecordParams
    from lfr.seeds import episode_seed
    from lfr.sim.simulation import Simulation

    if not trial.repaired:
        _break(trial.name)
    simulation, lengths = Simulation(trial.name, trial.task), []
    params = read_section(RecordParams, "record").attempt
    for index in range(trial.attempts):
        moments = list(attempt(simulation, params, episode_seed("demonstration", index)))
        if any(moment.success for moment in moments):
            lengths.append(len(moments))
    return {
        "embodiment": trial.name,
        "task": trial.task,
        "repaired": trial.repaired,
        "attempts": trial.attempts,
        "successes": len(lengths),
        "median_steps": float(np.median(lengths)) if lengths else None,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Percent of attempts that succeed, as Markdown; in brackets without the arm's repairs."""
    found = {(r["embodiment"], r["task"], r["repaired"]): r for r in rows}
    names = list(dict.fromkeys(row["embodiment"] for row in rows))
    lines = []
    for name in names:
        cells = [_share(found, name, task) for task in TASKS]
        lines.append(f"| `{name}` | {' | '.join(cells)} |")
    head = f"| | {' | '.join(task.stock_name for task in TASKS.values())} |"
    return "\n".join([head, "|---" * (len(TASKS) + 1) + "|", *lines])


def _share(found: dict[tuple[str, str, bool], dict[str, Any]], name: str, task: str) -> str:
    shares = [
        f"{100 * row['successes'] / row['attempts']:.0f}"
        for repaired in (True, False)
        if (row := found.get((name, task, repaired)))
    ]
    return f"{shares[0]} ({shares[1]})" if len(shares) > 1 else shares[0]


def _break(name: str) -> None:
    """In this process, the arm as robosuite has it."""
    from lfr.robots import ROBOTS
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
    jobs = [Job(run_trial, trial) for trial in every if trial.repaired]
    rows = list(run_jobs(jobs, description="experts", unit="trial").values())
    # One after the other in this process, which has no other arm's trials to come.
    rows += [run_trial(trial) for trial in every if not trial.repaired]
    for row in rows:
        print(
            f"{row['embodiment']:32s}{row['task']:14s}{row['successes']:3d} of {row['attempts']}"
            f"{'' if row['repaired'] else '  as robosuite has it'}"
        )
    if not arguments.only:
        path = arguments.out / "experts.json"
        write_json(path, {"trials": rows, "made_with": provenance()})
        text = PAGE.read_text()
        before, rest = text.split(BEGIN)[0], text.split(END)[1]
        PAGE.write_text(f"{before}{BEGIN}\n{table(rows)}\n{END}{rest}")
        print(path, PAGE, sep="\n")


if __name__ == "__main__":
    main()
