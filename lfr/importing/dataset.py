"""A robomimic file as a LeRobot v3.0 dataset, written by `lfr.data`'s own writers."""

from __future__ import annotations

import re
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import file_hash, write_json, write_whole
from lfr.data.checks import check_dataset
from lfr.data.episode import SUCCESS
from lfr.data.frames import FrameWriter
from lfr.data.layout import video_path
from lfr.data.meta import MetaWriter
from lfr.data.reopen import compare_with_sources
from lfr.errors import DataError, LfrError, ParameterError
from lfr.importing.features import Choice, Layout, video_keys
from lfr.importing.robomimic import Demo, RobomimicFile, open_robomimic
from lfr.progress import progress
from lfr.robots import ROBOTS
from lfr.tasks import TASKS

SOURCE = "meta/source.json"  # what the dataset was made of, as the file says it


@dataclass(frozen=True)
class About:
    """What a dataset is called and says of itself; None takes the file's word.

    Attributes:
        robot, task: names, such as "panda" and "lift".
        instruction: the task in words.
        fps: control steps per second.
    """

    robot: str | None = None
    task: str | None = None
    instruction: str | None = None
    fps: int | None = None


def import_robomimic(
    path: Path, out: Path, choice: Choice | None = None, about: About | None = None,
    mask: str | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Write the demonstrations of a robomimic file, or of one of its masks, as a dataset.

    It is built beside `out`, opened with LeRobotDataset and compared with the file row by row, and
    only then given its name.

    Returns:
        Counts: episodes, frames, successes, cameras; and the observations that were left out.

    Raises:
        LfrError: there is something at `out` already.
        DataError: the file is not what it should be; the message names demonstration and array.
    """
    path, out = Path(path), Path(out)
    choice, about = choice or Choice(), about or About()
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise LfrError(f"{out} is there already; name another folder, or remove it")
    with open_robomimic(path) as source:
        demos = [source.demo(name) for name in source.chosen(mask)]
        layout = Layout.of(source, choice, demos[0])
        known = _known(source, about)
        with write_whole(out) as partial:
            partial.mkdir()
            with closing(_Writer(partial, source, layout, known)) as writer:
                for demo in progress(demos, f"import {path.name}", "demo"):
                    writer.add(demo)
                _check_successes(path, choice, writer)
                writer.finish()
            write_json(partial / SOURCE, _source(writer, mask))
            check_dataset(partial, features=layout.features, fps=known.fps)
            episodes = ((path, layout.read(demo)) for demo in demos)
            compare_with_sources(partial, f"lfr/{out.name}", episodes)
    return {
        "episodes": writer.frames.episodes,
        "frames": writer.frames.frames,
        "successes": sum(row["success"] for row in writer.meta.rows),
        "cameras": list(layout.cameras),
        "left_out": list(layout.left_out),
    }


@dataclass(frozen=True)
class _Known:
    """`About` with nothing left open."""

    robot: str
    task: str
    instruction: str
    fps: int


def _known(source: RobomimicFile, about: About) -> _Known:
    kwargs = source.env_args.get("env_kwargs")
    kwargs = kwargs if isinstance(kwargs, dict) else {}
    fps = about.fps or kwargs.get("control_freq")
    if fps is None:
        raise ParameterError(f"{source.path} does not say its control_freq; give --fps")
    names = kwargs.get("robots") or []
    names = [names] if isinstance(names, str) else names
    robots = {robot.title: name for name, robot in ROBOTS.items()}
    robot = "_".join(robots.get(name, name.lower()) for name in names) or "unknown"
    env_name = str(source.env_args.get("env_name") or "unknown")
    task = next((task for task in TASKS.values() if task.stock_name == env_name), None)
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", env_name).replace("_", " ").lower()
    lang = source.env_args.get("lang") or kwargs.get("lang")
    return _Known(
        robot=about.robot or robot,
        task=about.task or (task.name if task else words.replace(" ", "_")),
        instruction=about.instruction or lang or (task.instruction if task else words),
        fps=int(fps),
    )


class _Writer:
    """Writes data, videos and meta, a demonstration at a time."""

    def __init__(self, root: Path, source: RobomimicFile, layout: Layout, known: _Known) -> None:
        from lfr.data.video import VideoWriter

        self.source, self.layout, self.known = source, layout, known
        self.digest = file_hash(source.path)
        self.entries: dict[str, dict[str, Any]] = {
            key: {"dtype": f.dtype, "shape": f.shape, "names": list(f.names or ())}
            for key, f in layout.features.items()
        }
        self.frames = FrameWriter(root, self.entries, known.fps)
        self.meta = MetaWriter(root, known.robot, known.fps)
        self.videos = {
            camera: VideoWriter(root, key, video_path(key), known.fps)
            for camera, key in video_keys(layout.cameras).items()
        }

    def add(self, demo: Demo) -> None:
        features = self.layout.read(demo)
        instruction = demo.instruction or self.known.instruction
        task_index = self.meta.task_index(instruction)
        where: dict[str, Any]
        where, stats = self.frames.write(features, task_index)
        for camera, video in self.videos.items():
            try:
                place, stats[video.key] = video.write(self.layout.images(demo, camera))
            except (OSError, TypeError, ValueError) as error:
                raise DataError(
                    "an image that cannot be encoded; --no-video leaves them out",
                    file=demo.file, column=f"{demo.name}/obs/{camera}_image", found=error,
                ) from error  # fmt: skip
            where |= place
        columns = {
            "success": bool(features[SUCCESS].any()),
            "robot": self.known.robot,
            "task_name": self.known.task,
            "source_file": demo.file.name,
            "source_sha256": self.digest,
            "source_demo": demo.name,
            **self._of(demo),
        }
        self.meta.add(len(demo), instruction, where, columns, stats)

    def close(self) -> None:
        self.frames.close()
        for video in self.videos.values():
            video.close()

    def finish(self) -> None:
        """Close the files and write all of meta."""
        self.close()
        entries = {video.key: video.feature() for video in self.videos.values()}
        stats = {video.key: video.stats for video in self.videos.values()}
        self.meta.write(self.entries | entries, self.frames.stats | stats)

    def _of(self, demo: Demo) -> dict[str, Any]:
        """Columns that only some files have; one of nothing but gaps would have no type."""
        columns: dict[str, Any] = {}
        if self.source.masks:
            columns["masks"] = [m for m, names in self.source.masks.items() if demo.name in names]
        digest = demo.model_sha256
        return columns if digest is None else {**columns, "model_sha256": digest}


def _check_successes(path: Path, choice: Choice, writer: _Writer) -> None:
    if not any(row["success"] for row in writer.meta.rows):
        raise DataError(
            "no demonstration succeeds; say with --success how it is to be told",
            file=path, found=f"--success {choice.success}", expected="at least one success",
        )  # fmt: skip


def _source(writer: _Writer, mask: str | None) -> dict[str, Any]:
    layout = writer.layout
    return {
        "format": "robomimic",
        "file": writer.source.path.name,
        "sha256": writer.digest,
        "mask": mask,
        "choice": layout.choice,
        "left_out": layout.left_out,
        "env_args": writer.source.env_args,
    }
