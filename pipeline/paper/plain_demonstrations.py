"""Stage plain_demonstrations: those of one robot and task, undisturbed; logs and dataset."""

import sys

from lfr.data.checks import check_dataset
from lfr.data.dataset import pack_dataset
from lfr.data.episode import FPS
from lfr.data.log_reader import list_logs
from lfr.demos.recorder import RecordParams, record_demonstrations
from lfr.program import run_stage
from pipeline._stage import dataset_name, unfinished_work, write_metrics
from pipeline.paper._plain import DATASETS, LOGS, plain_section

CODE = ("lfr.demos", "lfr.sim", "lfr.data", "lfr.robots", "lfr.tasks", "lfr.seeds")


def main(robot: str, task: str) -> None:
    """Record data/paper-plain/logs/<robot>-<task> and pack it into data/paper-plain/lerobot.

    As the main job's stages record and pack, but for the parameters, and without video: nothing
    learns from it.
    """
    name = dataset_name(robot, task)
    params = plain_section(RecordParams, "record")
    work = unfinished_work("paper-plain-demonstrations", name, params, code=CODE)
    recorded = record_demonstrations(robot, task, params, LOGS / name, work)
    out = DATASETS / name
    packed = pack_dataset(list_logs(LOGS / name), out, video=False, fps=FPS)
    check_dataset(out, fps=FPS, robot=robot, task=task)
    write_metrics("paper/plain_demonstrations", name, {"record": recorded, "pack": packed})


if __name__ == "__main__":
    sys.exit(run_stage(main))
