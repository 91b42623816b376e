"""A copy of a clean dataset, to be changed: what is changed is written, the rest stays links."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from benchmarks.checkers.pictures import encode, frames_of
from lfr.curation.contents import EPISODES, INFO, NOT_NUMBERS, STATS, with_column
from lfr.curation.exact_stats import dataset_stats, episode_stats, pooled_stats
from lfr.data.stats import image_stats

ROWS = "data/chunk-000/file-000.parquet"
EPISODE_ROWS = f"{EPISODES}/chunk-000/file-000.parquet"


class DatasetCopy:
    """A dataset of one file of rows, one of episodes and one video.

    What is read of it may be changed, or put in its place: `save` writes what then differs.

    Attributes:
        root: its folder.
        clean_logs: of the clean dataset, where it has logs.
        logs: where a copy of them would be, of which one is changed.
        info, stats: meta/info.json and meta/stats.json.
        rows, episodes: the rows, and meta/episodes.
    """

    def __init__(self, root: Path, clean: Path | None = None) -> None:
        clean = clean or root
        self.root = root
        self.clean_logs = clean.parent / f"{clean.name}-logs"
        self.logs = root.parent / f"{root.name}-logs"

    @classmethod
    def of(cls, clean: Path, root: Path) -> DatasetCopy:
        """Links to the files of a clean dataset; what was there before is gone."""
        shutil.rmtree(root, ignore_errors=True)
        shutil.copytree(clean, root, copy_function=os.link)
        return cls(root, clean)

    @cached_property
    def info(self) -> Any:
        return json.loads((self.root / INFO).read_text(encoding="utf-8"))

    @cached_property
    def stats(self) -> Any:
        return json.loads((self.root / STATS).read_text(encoding="utf-8"))

    @cached_property
    def rows(self) -> pa.Table:
        return pq.read_table(self.root / ROWS)

    @cached_property
    def episodes(self) -> pa.Table:
        return pq.read_table(self.root / EPISODE_ROWS)

    def save(self) -> None:
        """Write what was changed, each file anew, so that the clean dataset's is left alone."""
        for name, file in (("info", INFO), ("stats", STATS)):
            if name in self.__dict__:
                text = json.dumps(getattr(self, name), indent=4)
                place = self.root / file
                if place.is_file() and json.loads(text) != json.loads(place.read_text("utf-8")):
                    self.replace(file, lambda new, text=text: new.write_text(text, "utf-8"))
        for name, file in (("rows", ROWS), ("episodes", EPISODE_ROWS)):
            table = self.__dict__.get(name)
            if table is not None and not _same(table, pq.read_table(self.root / file)):
                self.replace(file, lambda new, table=table: pq.write_table(table, new))

    def replace(self, file: str, write: Callable[[Path], object]) -> None:
        """Write a file anew; never through a link."""
        new = self.root / f"{file}.new"
        write(new)
        new.replace(self.root / file)

    @property
    def camera(self) -> str:
        """The feature of its one camera."""
        return next(key for key, f in self.info["features"].items() if f["dtype"] == "video")

    @property
    def video(self) -> str:
        return f"videos/{self.camera}/chunk-000/file-000.mp4"

    def numbers(self) -> list[str]:
        """Its features that are numbers."""
        return [k for k, f in self.info["features"].items() if f["dtype"] not in NOT_NUMBERS]

    def values(self, key: str) -> NDArray:
        """A feature of all rows, to be changed: (N,), (N, D) or (N, H, W)."""
        column = self.rows[key].combine_chunks()
        if pa.types.is_list(column.type) or pa.types.is_fixed_size_list(column.type):
            return np.array(column.to_pylist(), np.float32)
        return np.array(column)

    def put(self, key: str, values: Any) -> None:
        """Put these values in a feature's place, in its type."""
        if isinstance(values, np.ndarray) and values.ndim > 1:
            values = pa.array(values.tolist(), self.rows.schema.field(key).type)
        self.rows = with_column(self.rows, key, values)

    def change(self, key: str, where: Any, value: Any) -> None:
        """Put a value into one place, or some, of a feature."""
        values = self.values(key)
        values[where] = value
        self.put(key, values)

    def of_episodes(self, column: str) -> list[Any]:
        return self.episodes[column.replace("VIDEO", f"videos/{self.camera}")].to_pylist()

    def put_of_episodes(self, column: str, values: Sequence[Any]) -> None:
        """Put a column of meta/episodes; VIDEO in its name stands for videos/<camera>."""
        name = column.replace("VIDEO", f"videos/{self.camera}")
        type = self.episodes.schema.field(name).type
        self.episodes = with_column(self.episodes, name, pa.array(list(values), type))

    def span(self, episode: int) -> slice:
        """The rows of an episode."""
        start = self.of_episodes("dataset_from_index")[episode]
        return slice(start, start + self.of_episodes("length")[episode])

    def restat(self, *keys: str) -> None:
        """Statistics of these features, or of all numbers, as a recorder would have made them."""
        lengths = np.array(self.of_episodes("length"))
        for key in keys or self.numbers():
            values = self.values(key)
            shape = values.shape[1:] or (1,)
            self.stats[key] = {
                name: found.reshape(shape if name != "count" else (1,)).tolist()
                for name, found in dataset_stats(values).items()
            }
            for name, found in episode_stats(values, lengths).items():
                of_each = found.reshape(len(lengths), *(shape if name != "count" else (1,)))
                column = f"stats/{key}/{name}"
                type = self.episodes.schema.field(column).type if self._has(column) else None
                self.episodes = with_column(self.episodes, column, pa.array(of_each.tolist(), type))

    def _has(self, column: str) -> bool:
        return column in self.episodes.column_names

    def restat_pictures(self, shown: Mapping[int, NDArray[np.uint8]]) -> None:
        """Statistics of some episodes' pictures anew, (N, H, W, 3) each, and those of all."""
        found = {
            episode: image_stats(
                [np.bincount(frames[..., c].ravel(), minlength=256) for c in range(3)], len(frames)
            )
            for episode, frames in shown.items()
        }
        for name in next(iter(found.values())):
            column = f"stats/{self.camera}/{name}"
            of_each = self.of_episodes(column)
            for episode, stats in found.items():
                of_each[episode] = stats[name].tolist()
            self.put_of_episodes(column, of_each)
        self.stats[self.camera] = pooled_stats(self.episodes, self.camera)

    def frames(self) -> NDArray[np.uint8]:
        """All frames of its video, (N, H, W, 3), to be looked at only."""
        return frames_of(self.root / self.video)

    def film(self, frames: NDArray[np.uint8], **how: Any) -> None:
        """Encode these frames in its video's place, as `pictures.encode`."""
        self.replace(self.video, lambda new: encode(frames, new, **how))

    def rebuild(self, parts: Sequence[NDArray[np.int64]], origins: Sequence[int],
                filmed: Sequence[NDArray[np.int64]] | None = None) -> None:  # fmt: skip
        """Episodes anew, counted and described as a recorder would have.

        Args:
            parts: of each new episode, which of the rows it is made of.
            origins: of each, the episode whose columns of meta/episodes it has.
            filmed: of each, which frames; by default those of its rows.
        """
        video = self.frames()
        lengths, count = np.array([len(part) for part in parts]), len(parts)
        ends = np.cumsum(lengths)
        frame = np.concatenate([np.arange(n) for n in lengths])
        self.rows = self.rows.take(pa.array(np.concatenate(parts)))
        for key, values in (
            ("index", np.arange(len(frame))), ("frame_index", frame),
            ("episode_index", np.repeat(np.arange(count), lengths)),
            ("timestamp", (frame / self.info["fps"]).astype(np.float32)),
        ):  # fmt: skip
            self.put(key, values)
        self.episodes = self.episodes.take(pa.array(list(origins)))
        shown = filmed or parts
        film_ends = np.cumsum([len(part) for part in shown]) / self.info["fps"]
        for column, of_each in (
            ("episode_index", np.arange(count)), ("length", lengths),
            ("dataset_from_index", ends - lengths), ("dataset_to_index", ends),
            ("VIDEO/from_timestamp", [0.0, *film_ends[:-1]]), ("VIDEO/to_timestamp", film_ends),
        ):  # fmt: skip
            self.put_of_episodes(column, list(of_each))
        self.info |= {"total_episodes": count, "total_frames": len(frame),
                      "splits": {"train": f"0:{count}"}}  # fmt: skip
        self.restat()
        self.restat_pictures({episode: video[part] for episode, part in enumerate(shown)})
        order = np.concatenate(shown)
        if not np.array_equal(order, np.arange(len(video))):
            self.film(video[order])


def _same(one: pa.Table, other: pa.Table) -> bool:
    """Whether two tables are the same, NaN and all."""
    return one.schema.equals(other.schema) and all(
        a.combine_chunks().to_pylist() == b.combine_chunks().to_pylist()
        for a, b in zip(one.columns, other.columns, strict=True)
    )
