"""Stage record: successful demonstrations of one robot and task, one MCAP log each."""

import sys
from pathlib import Path

from lfr.demos.recorder import RecordParams, record_demonstrations
from lfr.params import read_section
from lfr.program import run_stage
from lfr.robots import robot as robot_named
from lfr.tasks import task as task_named
from pipeline._stage import unfinished_work, write_metrics

CODE = ("lfr.demos", "lfr.sim", "lfr.data", "lfr.robots", "lfr.tasks", "lfr.seeds")


def main(robot: str, task: str) -> None:
    """Record demonstrations of a task by a robot into data/logs/<robot>-<task>."""
    robot_named(robot)
    task_named(task)
    params = read_section(RecordParams, "record")
    name = f"{robot}-{task}"
    work = unfinished_work("record", name, params, code=CODE)
    metrics = record_demonstrations(robot, task, params, Path("data/logs") / name, work)
    write_metrics(Path("results/record") / f"{name}.json", metrics)


if __name__ == "__main__":
    sys.exit(run_stage(main))
