"""Training data: a dataset's rows as tensors, and windows of actions gathered from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import torch
from numpy.typing import NDArray
from torch import Tensor

from lfr.columns import ActionSpace, Columns
from lfr.data import tables
from lfr.data.episode import JOINT_POSITION, REWARD, SUCCESS
from lfr.data.selection import RECORDED, Chosen, select
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError


@dataclass(frozen=True)
class DemonstrationSet:
    """The episodes of one dataset, end to end.

    Attributes:
        observations: (N, D) float32; of this project's own datasets observation.state, then
            observation.environment_state.
        actions: (N, A) float32 in [-1, 1].
        rewards: (N,) float32, after the action of the same row; None where the dataset has none.
        successes: (N,) bool, after the action of the same row; None where the dataset has none.
        starts: (E + 1,) int64; episode e is the rows starts[e] to starts[e + 1] - 1.
        observation_names: of each dimension.
        action_space: the name of each dimension, and what -1 and 1 stand for.
        robot, task, fps: as the dataset says; the task is "" where it does not.
        seeds: of each episode, or () where the dataset does not say.
        joint_positions: (N, J) rad, float32, before the action; None where the dataset has none, or
            columns of one's own are read.
    """

    observations: Tensor
    actions: Tensor
    rewards: Tensor | None
    successes: Tensor | None
    starts: Tensor
    observation_names: tuple[str, ...]
    action_space: ActionSpace
    robot: str
    task: str
    fps: float
    seeds: tuple[int, ...] = ()
    joint_positions: Tensor | None = None

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.actions)

    @property
    def episodes(self) -> int:
        return len(self.starts) - 1

    @property
    def lengths(self) -> Tensor:
        """(E,) rows of each episode."""
        return self.starts.diff()

    def select(self, episodes: Sequence[int]) -> DemonstrationSet:
        """The episodes of these numbers, in this order."""
        chosen = torch.as_tensor(list(episodes), dtype=torch.int64)
        bounds = [(int(self.starts[e]), int(self.starts[e + 1])) for e in chosen.tolist()]
        pieces = [torch.arange(first, end) for first, end in bounds]
        rows = torch.cat(pieces) if pieces else torch.empty(0, dtype=torch.int64)
        starts = torch.zeros(len(chosen) + 1, dtype=torch.int64)
        starts[1:] = self.lengths[chosen].cumsum(0)
        return replace(
            self,
            observations=self.observations[rows],
            actions=self.actions[rows],
            rewards=None if self.rewards is None else self.rewards[rows],
            successes=None if self.successes is None else self.successes[rows],
            joint_positions=None if self.joint_positions is None else self.joint_positions[rows],
            starts=starts,
            seeds=tuple(self.seeds[e] for e in chosen.tolist()) if self.seeds else (),
        )

    def split(self, held_out: float, seed: int) -> tuple[DemonstrationSet, DemonstrationSet]:
        """Training and held-out episodes, drawn by episode so that no window is seen from both.

        Args:
            held_out: fraction of the episodes, rounded: at least one of two or more unless it is
                0, and never all.
            seed: the same seed and number of episodes give the same split.
        """
        if not 0 <= held_out < 1:
            raise ValueError(f"held_out is a fraction in [0, 1), found {held_out}")
        count = round(held_out * self.episodes)
        if held_out > 0:
            count = min(max(count, 1), self.episodes - 1)
        order = np.random.default_rng(seed).permutation(self.episodes)
        return self.select(sorted(order[count:])), self.select(sorted(order[:count]))


class WindowBatch(NamedTuple):
    """Windows of H actions.

    `observations` (B, D) where they start, `actions` (B, H, A), and `is_pad` (B, H) bool, true for
    actions past the episode's end, which repeat its last.
    """

    observations: Tensor
    actions: Tensor
    is_pad: Tensor


class Windows:
    """All windows of `horizon` actions in a set of demonstrations.

    Not padded, a window lies within one episode. Padded, one starts at every row, and the
    episode's last action is repeated past its end: what LeRobotDataset returns for
    `delta_timestamps={"action": [0, 1 / fps, ...]}`, a test proves.
    """

    def __init__(self, demonstrations: DemonstrationSet, horizon: int, *, padded: bool) -> None:
        if horizon < 1:
            raise ValueError(f"a window has at least one action, found a horizon of {horizon}")
        self.demonstrations, self.horizon, self.padded = demonstrations, horizon, padded
        lengths = demonstrations.lengths
        rows = torch.arange(len(demonstrations))
        last = (demonstrations.starts[1:] - 1).repeat_interleave(lengths)  # of the row's episode
        starting = torch.ones_like(rows, dtype=torch.bool) if padded else rows + horizon - 1 <= last
        self.starts = rows[starting]  # (M,) row of each window's first action
        self._last = last[starting]  # (M,) row of its episode's last action

    def __len__(self) -> int:
        return len(self.starts)

    def gather(self, index: Tensor) -> WindowBatch:
        """The windows of these numbers, (B,) int64 in [0, len)."""
        rows = self.starts[index, None] + torch.arange(self.horizon)  # (B, H)
        last = self._last[index, None]
        actions = self.demonstrations.actions[rows.minimum(last)]
        return WindowBatch(
            self.demonstrations.observations[self.starts[index]], actions, rows > last
        )

    def all(self) -> WindowBatch:
        return self.gather(torch.arange(len(self)))


def read_dataset(
    path: Path, columns: Columns = RECORDED, instruction: str | None = None
) -> DemonstrationSet:
    """Read a LeRobot v3.0 dataset from its Parquet files.

    Args:
        columns: what becomes observation and action; by default this project's own.
        instruction: the task whose episodes are read, in the dataset's words; None reads all.

    Raises:
        DataError: there is no dataset, a file is cut off, a column or dimension is missing, or no
            episode is of this task. `check_dataset` looks at the values too.
    """
    files = DatasetFiles.open(Path(path))
    chosen = select(files, columns)
    wanted = (REWARD, SUCCESS, *((JOINT_POSITION,) if columns is RECORDED else ()))
    extra = [column for column in wanted if column in files.features]
    table = files.data([*columns.needed, *extra])
    lengths = files.episodes["length"].to_numpy()
    if lengths.sum() != len(table):
        raise DataError(
            "another number of rows than the episodes have; pack the logs again",
            file=files.path,
            found=len(table),
            expected=int(lengths.sum()),
        )
    observation = np.concatenate(
        [_taken(table, part, files) for part in chosen.observation], axis=1
    )
    action = chosen.space.normalized(_taken(table, chosen.action, files))
    seeds = files.episodes["seed"].to_pylist() if "seed" in files.episodes.column_names else ()
    found = DemonstrationSet(
        observations=torch.from_numpy(np.asarray(observation, np.float32)),
        actions=torch.from_numpy(np.array(action)),
        rewards=_scalars(table, REWARD) if REWARD in extra else None,
        successes=_scalars(table, SUCCESS) if SUCCESS in extra else None,
        starts=torch.from_numpy(np.concatenate([[0], np.cumsum(lengths)])),
        observation_names=chosen.observation_names,
        action_space=chosen.space,
        robot=files.info.get("robot_type") or "",
        task=instruction if instruction is not None else ", ".join(files.task_names()),
        fps=files.info["fps"],
        seeds=tuple(seeds),
        joint_positions=_vectors(table, JOINT_POSITION) if JOINT_POSITION in extra else None,
    )
    return found if instruction is None else found.select(episodes_of(files, instruction))


def episodes_of(files: DatasetFiles, instruction: str) -> list[int]:
    """The numbers of the episodes that are of one task alone, by its words.

    Raises:
        DataError: there are none; the message lists the dataset's tasks.
    """
    column = "tasks"
    if column not in files.episodes.column_names:
        folder = files.path / "meta" / "episodes"
        raise DataError("a column is missing", file=folder, column=column)
    tasks = files.episodes[column].to_pylist()
    episodes = [number for number, known in enumerate(tasks) if list(known) == [instruction]]
    if not episodes:
        named = sorted({task for known in tasks for task in known})
        raise DataError(
            "no episode is of this task",
            file=files.path,
            found=", ".join(map(repr, named)),
            expected=repr(instruction),
        )
    return episodes


def _taken(table: pa.Table, part: Chosen, files: DatasetFiles) -> NDArray:
    """(N, D) of a column's chosen dimensions, as models know them."""

    def column(name: str) -> NDArray:
        values = tables.values(table, name)
        return values.reshape(len(values), -1)

    try:
        return part.values(column)
    except ValueError as error:
        raise DataError(str(error), file=files.path / "data", column=part.column) from None


def _vectors(table: pa.Table, column: str) -> Tensor:
    values = np.array(tables.values(table, column), np.float32)
    return torch.from_numpy(values.reshape(len(values), -1))


def _scalars(table: pa.Table, column: str) -> Tensor:
    return torch.from_numpy(np.array(tables.values(table, column)).reshape(-1))
