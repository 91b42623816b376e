"""The datasets that a new one is made of: opened, of one kind, with the episodes wanted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.contents import INFO, Contents
from lfr.curation.finding import readable
from lfr.errors import DataError

CHUNK = 1000  # files in a chunk, where info.json does not say; LeRobot's own default


@dataclass(frozen=True)
class Part:
    """Episodes of one dataset, in the order in which they are wanted."""

    path: Path
    episodes: Sequence[int]


@dataclass(frozen=True)
class Source:
    """A part whose dataset has been opened.

    Attributes:
        episodes: by their index, episode_index.
        positions: which rows of meta/episodes these are: where an episode has been taken out by
            hand, others than their indices.
    """

    contents: Contents
    episodes: Sequence[int]
    positions: Sequence[int]

    @classmethod
    def open(cls, part: Part) -> Source:
        """Raises DataError where there is no such dataset, or no such episode in it."""
        with readable(part.path):
            contents = Contents.open(part.path)
            known = contents.episode_column("episode_index").tolist()
        position = dict(zip(known, range(len(known)), strict=True))
        outside = [episode for episode in part.episodes if episode not in position]
        if outside:
            expected = f"{min(known)} to {max(known)}" if known else "none"
            raise DataError("no such episode", file=part.path, episode=outside[0],
                            expected=expected)  # fmt: skip
        return cls(contents, part.episodes, [position[episode] for episode in part.episodes])

    @property
    def path(self) -> Path:
        return self.contents.path

    @property
    def lengths(self) -> NDArray[np.int64]:
        """(E,) rows of the episodes that are wanted."""
        return self.contents.lengths[list(self.positions)]


def open_parts(parts: Iterable[Part]) -> list[Source]:
    """The parts' datasets.

    Raises:
        DataError: one cannot be read, lacks an episode, or is of another kind than the first.
    """
    sources = [Source.open(part) for part in parts]
    for source in sources[1:]:
        _same_kind(sources[0].contents, source.contents)
    return sources


def new_file(out: Path, model: Contents, template: str, number: int, **names: str) -> Path:
    """The `number`-th file of a new dataset at `out`, named as in `model`; its folder is made."""
    chunk, file = divmod(number, files_per_chunk(model))
    name = model.named(template, chunk_index=chunk, file_index=file, **names)
    path = out / name
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def files_per_chunk(model: Contents) -> int:
    found = model.info.get("chunks_size")
    return found if isinstance(found, int) and found > 0 else CHUNK


def _same_kind(first: Contents, other: Contents) -> None:
    expected, found = _kind(first), _kind(other)
    for column in {**expected, **found}:
        if expected.get(column) != found.get(column):
            raise DataError(f"a dataset of another kind than {first.path}", file=other.path / INFO,
                            column=column, found=found.get(column),
                            expected=expected.get(column))  # fmt: skip


def _kind(contents: Contents) -> dict[str, Any]:
    with readable(contents.path):
        features = {
            f"features.{key}": {name: f.get(name) for name in ("dtype", "shape", "names")}
            for key, f in contents.features.items()
        }
        return {"fps": contents.fps, "robot_type": contents.info.get("robot_type"), **features}
