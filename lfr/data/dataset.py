"""Packing logs into a LeRobot v3.0 dataset.

The files are written directly, by LeRobot's own schemas and paths, and equal what its `add_frame`
and `save_episode` write (a test compares them), for three reasons: `save_episode` spends 290 ms on
a state-only episode, has no place for columns of an episode (lerobot issue 2999), and computes
wrong quantiles (issue 4156).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from lfr.artifacts import file_hash, write_whole
from lfr.data.checks import check_dataset
from lfr.data.episode import FPS, IMAGES, Episode
from lfr.data.frames import FrameWriter
from lfr.data.layout import video_path
from lfr.data.log_checks import LogKind
from lfr.data.log_reader import read_log
from lfr.data.meta import MetaWriter
from lfr.data.reopen import compare_with_sources
from lfr.data.stats import Stats
from lfr.errors import DataError


def pack_dataset(
    logs: Sequence[Path], out: Path, *, video: bool = True, fps: int = FPS
) -> dict[str, Any]:
    """Pack logs, in this order, into the dataset `out`; what stood there is replaced at the end.

    It is built beside `out`, opened with LeRobotDataset and compared with the logs row by row, and
    only then given its name.

    Args:
        logs: MCAP logs of one robot and task.
        out: the dataset's folder; its repo_id is `lfr/<name of the folder>`.
        video: make `observation.images.<camera>` videos, where every log has images.
        fps: frames per second that the logs must have.

    Returns:
        Counts: episodes, frames, successes, cameras.

    Raises:
        DataError: a log is missing, cut off, or of another robot, task, layout or rate than the
            first; a value is not finite; or what was written does not read back as it should.
    """
    if not logs:
        raise DataError("no logs to pack; record episodes first", file=out)
    with write_whole(Path(out)) as partial:
        partial.mkdir()
        with closing(_DatasetWriter(partial, logs, video, fps)) as writer:
            for log in logs:
                writer.add(Path(log))
            writer.finish()
        check_dataset(partial, features=writer.kind.episode.schema, fps=fps)
        episodes = ((Path(log), read_log(Path(log)).features) for log in logs)
        compare_with_sources(partial, f"lfr/{Path(out).name}", episodes)
    return {
        "episodes": writer.frames.episodes,
        "frames": writer.frames.frames,
        "successes": sum(row["success"] for row in writer.meta.rows),
        "cameras": list(writer.cameras),
    }


class _DatasetWriter:
    """Writes data, videos and meta of one dataset, an episode at a time."""

    def __init__(self, root: Path, logs: Sequence[Path], video: bool, fps: int) -> None:
        from lfr.data.video import VideoWriter

        log = Path(logs[0])
        first = read_log(log)
        self.features: dict[str, dict[str, Any]] = {
            key: {"dtype": f.dtype, "shape": f.shape, "names": list(f.names or ())}
            for key, f in first.schema.items()
        }
        self.frames = FrameWriter(root, self.features, fps)
        self.cameras = {
            camera: VideoWriter(root, IMAGES + camera, video_path(IMAGES + camera), fps)
            for camera in (first.images if video else ())
        }
        self.meta = MetaWriter(root, first.robot, fps)
        self.kind = LogKind(log, first, tuple(self.cameras), fps)

    def add(self, log: Path) -> None:
        episode = self.kind.episode if log == self.kind.log else read_log(log)
        index = self.frames.episodes
        self.kind.check(episode, log, index)
        instruction = episode.metadata["instruction"]
        where, stats = self.frames.write(episode.features, self.meta.task_index(instruction))
        places, image_stats = self._write_images(episode, log, index)
        columns = {
            "seed": episode.seed,
            "success": bool(episode.success),
            "robot": episode.robot,
            "task_name": episode.task,
            "log_file": log.name,
            "log_sha256": file_hash(log),
        }
        where = {**where, **places}
        self.meta.add(len(episode), instruction, where, columns, stats | image_stats)

    def close(self) -> None:
        """Close the Parquet file and the videos, whole or not."""
        self.frames.close()
        for camera in self.cameras.values():
            camera.close()

    def finish(self) -> None:
        """Close the files and write all of meta."""
        self.close()
        cameras = self.cameras.values()
        videos = {camera.key: camera.feature() for camera in cameras}
        image_stats = {camera.key: camera.stats for camera in cameras}
        self.meta.write(self.features | videos, self.frames.stats | image_stats)

    def _write_images(
        self, episode: Episode, log: Path, index: int
    ) -> tuple[dict[str, float], dict[str, Stats]]:
        where: dict[str, float] = {}
        stats: dict[str, Stats] = {}
        for camera, writer in self.cameras.items():
            try:
                place, stats[writer.key] = writer.write(episode.images[camera])
            except (OSError, ValueError) as error:
                raise DataError(
                    "an image that cannot be encoded",
                    file=log,
                    episode=index,
                    column=writer.key,
                    found=error,
                ) from error
            where |= place
        return where, stats
