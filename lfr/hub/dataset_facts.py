"""What a dataset's card says of it: counted in its files, and noted by the stages that made it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import read_json
from lfr.data.episode import ACTION, ENVIRONMENT_STATE, JOINT_POSITION, STATE
from lfr.data.features import names_of, settings_of
from lfr.data.tables import DatasetFiles
from lfr.embodiments import known_action
from lfr.errors import DataError, UnknownNameError
from lfr.spaces import Space, joint_position, space
from lfr.tasks import TASKS

FOLDERS = ("meta", "data", "videos")  # of a LeRobot v3.0 dataset
NOTED = ("seed", "success", "robot", "task_name", "log_file", "log_sha256")  # in meta/episodes


@dataclass(frozen=True)
class Column:
    """A feature as meta/info.json has it; `codec` is a video's, else empty."""

    key: str
    dtype: str
    shape: tuple[int, ...]
    names: tuple[str, ...]
    codec: str = ""


@dataclass(frozen=True)
class DatasetFacts:
    """What its files say.

    Attributes:
        name: of its folder.
        robot, tasks: as the dataset names them; "" and none where it does not.
        instructions: the tasks in words, as LeRobot keeps them.
        fps: frames per second.
        lengths: shortest, median and longest episode, in frames.
        successes: episodes that succeeded; None where the dataset does not say it of each.
        seeds: first and last seed of its episodes; None where the dataset does not say it of each.
        size: bytes of its files.
        noted: which of `NOTED` its episodes have.
    """

    name: str
    robot: str
    tasks: tuple[str, ...]
    instructions: tuple[str, ...]
    fps: float
    episodes: int
    frames: int
    lengths: tuple[float, float, float]
    successes: int | None
    seeds: tuple[int, int] | None
    size: int
    columns: tuple[Column, ...]
    noted: tuple[str, ...] = NOTED

    @property
    def cameras(self) -> tuple[Column, ...]:
        return tuple(column for column in self.columns if column.dtype == "video")

    @property
    def our_layout(self) -> bool:
        """Whether states and actions are those of docs/data.md; others may use the same names."""
        names = {column.key: column.names for column in self.columns}
        known = known_action(names.get(ACTION, ()), self.robot) is not None
        return known and "gripper_aperture" in names.get(STATE, ())

    def space(self, column: Column) -> Space | None:
        """What the dimensions of a column are; None where nothing says it.

        In another layout than this project's the same names may mean something else: `gripper` may
        be degrees.
        """
        if not self.our_layout:
            return None
        if column.key == ACTION:
            return known_action(column.names, self.robot)
        if column.key == JOINT_POSITION:
            return Space((joint_position(column.names),))
        if column.key == ENVIRONMENT_STATE:  # the names do not say a yaw's symmetry; the task does
            observed = (TASKS[task].environment for task in self.tasks if task in TASKS)
            known = next((each for each in observed if each.names == column.names), None)
            if known is not None:
                return known
        try:
            return space(column.names)
        except UnknownNameError:
            return None


@dataclass(frozen=True)
class Making:
    """What the stages record and pack say of how a dataset was made (results/record, /pack)."""

    record: dict[str, Any]
    pack: dict[str, Any]


def read_facts(path: Path) -> DatasetFacts:
    """Read a dataset's facts from its files, without importing LeRobot.

    Raises:
        DataError: no dataset, or a cut-off one.
    """
    import numpy as np

    path = Path(path)
    dataset = DatasetFiles.open(path)
    episodes = dataset.episodes
    lengths = episodes["length"].to_numpy()
    if not len(lengths):
        raise DataError("no episodes", file=path / "meta" / "episodes")

    def column(name: str) -> list[Any]:
        return episodes[name].to_pylist() if name in episodes.column_names else []

    def of_each(name: str, type: type) -> list[Any]:
        """The column where every episode has a value of this type; merged ones may have gaps."""
        values = column(name)
        return values if all(isinstance(value, type) for value in values) else []

    seeds, successes = of_each("seed", int), of_each("success", bool)
    return DatasetFacts(
        name=path.resolve().name,
        robot=dataset.info.get("robot_type") or "",
        tasks=tuple(sorted({str(name) for name in column("task_name") if name is not None})),
        instructions=tuple(dict.fromkeys(one for tasks in column("tasks") for one in tasks or ())),
        fps=dataset.fps,
        episodes=len(lengths),
        frames=int(lengths.sum()),
        lengths=(int(lengths.min()), float(np.median(lengths)), int(lengths.max())),
        successes=sum(successes) if successes else None,
        seeds=(min(seeds), max(seeds)) if seeds else None,
        size=sum(file.stat().st_size for file in dataset_files(path)),
        columns=tuple(_column(key, given) for key, given in dataset.features.items()),
        noted=tuple(name for name in NOTED if name in episodes.column_names),
    )


def dataset_files(path: Path) -> list[Path]:
    """The files of a LeRobot v3.0 dataset, without what lies beside them or is hidden.

    Raises:
        DataError: a link to a folder, or to nothing: what is behind it would be left out.
    """
    found = (file for folder in FOLDERS for file in sorted((path / folder).rglob("*")))
    shown = [file for file in found if not _hidden(file.relative_to(path))]
    for file in shown:
        if file.is_symlink() and not file.is_file():
            raise DataError("a link that is not followed", file=file,
                            expected="a file or a folder, or a link to a file")  # fmt: skip
    return [file for file in shown if file.is_file()]


def read_making(facts: DatasetFacts, results: Path) -> Making | None:
    """What the stages noted of this dataset; None where they noted nothing.

    Raises:
        DataError: they speak of other numbers than the dataset's files.
    """
    files = [results / stage / f"{facts.name}.json" for stage in ("record", "pack")]
    if not all(file.is_file() for file in files):
        return None
    record, pack = (read_json(file) for file in files)
    noted = [
        (files[0], "episodes", record["episodes"], facts.episodes),
        (files[0], "frames", record["frames"], facts.frames),
        (files[0], "seeds", tuple(record["seeds"].values()), facts.seeds),
        (files[1], "frames", pack["frames"], facts.frames),
        (files[1], "successes", pack["successes"], facts.successes),
        (files[1], "bytes", pack["bytes"], facts.size),
    ]
    for file, what, found, expected in noted:
        if found != expected:
            raise DataError(
                f"the results speak of another dataset than {facts.name}; run `dvc repro`",
                file=file,
                column=what,
                found=found,
                expected=f"{expected}, as in its files",
            )
    return Making(record, pack)


def _column(key: str, given: dict[str, Any]) -> Column:
    codec = settings_of(given).get("video.codec") or ""
    return Column(key, given["dtype"], tuple(given["shape"]), tuple(names_of(given)), codec)


def _hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)
