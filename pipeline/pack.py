"""Stage pack: the logs of one robot and task as a LeRobot v3.0 dataset."""

import sys
from dataclasses import dataclass
from pathlib import Path

from lfr.data.checks import check_dataset
from lfr.data.dataset import pack_dataset
from lfr.data.episode import FPS
from lfr.data.log_reader import list_logs
from lfr.params import read_section
from lfr.program import run_stage
from pipeline._stage import dataset_name, write_metrics


@dataclass(frozen=True)
class PackParams:
    """Parameters of the pack stage: section ``pack`` of params.yaml."""

    video: bool = True  # where the logs have pictures
    fps: int = FPS  # that the logs must have


def main(robot: str, task: str) -> None:
    """Pack data/logs/<robot>-<task> into the dataset data/lerobot/<robot>-<task>."""
    name = dataset_name(robot, task)
    params = read_section(PackParams, "pack")
    out = Path("data/lerobot") / name
    logs = list_logs(Path("data/logs") / name)
    counts = pack_dataset(logs, out, video=params.video, fps=params.fps)
    check_dataset(out, fps=params.fps, robot=robot, task=task)
    size = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    write_metrics("pack", name, {**counts, "bytes": size})


if __name__ == "__main__":
    sys.exit(run_stage(main))
