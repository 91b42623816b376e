"""Stage record: successful demonstrations of one robot and task, one MCAP log each."""

import sys
from pathlib import Path

from lfr.demos.recorder import RecordParams, record_demonstrations
from lfr.params import read_section
from lfr.program import run_stage
from pipeline._stage import dataset_name, unfinished_work, write_metrics


def main(robot: str, task: str) -> None:
    """Record demonstrations of a task by a robot into data/logs/<robot>-<task>."""
    name = dataset_name(robot, task)
    params = read_section(RecordParams, "record")
    work = unfinished_work("record", name, params)
    metrics = record_demonstrations(robot, task, params, Path("data/logs") / name, work)
    write_metrics("record", name, metrics)


if __name__ == "__main__":
    sys.exit(run_stage(main))
