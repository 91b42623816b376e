"""A dataset of chosen episodes of other datasets: what deleting, splitting and merging all are.

LeRobot 0.6.1's delete_episodes and split_dataset drop the columns of meta/episodes that it does not
know, and its statistics are averages of the episodes' (issues 2999 and 4156). Here every column is
kept, and every statistic is computed from the rows.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from lfr.curation.checks.counts import task_words
from lfr.curation.clips import Clip, write_clip
from lfr.curation.contents import INFO, STATS, TASKS, Contents, runs, with_column
from lfr.curation.exact_stats import dataset_stats, episode_stats, pooled_stats
from lfr.curation.finding import Finding, Unreadable
from lfr.curation.verify import verify_dataset
from lfr.errors import DataError

MEGABYTES = 100  # of one Parquet file, where info.json does not say; LeRobot's own default
CHUNK = 1000  # files in a chunk, likewise


@dataclass(frozen=True)
class Part:
    """Episodes of one dataset, in the order in which they are wanted."""

    path: Path
    episodes: Sequence[int]


def assemble(parts: Sequence[Part], out: Path) -> dict[str, int]:
    """Write the episodes of `parts`, one after the other, as a new dataset; and verify it.

    Every column of meta/episodes is kept but those that say where the episode is; one that a part
    has not is empty for its episodes. Videos are not encoded again where they can be cut.

    Args:
        parts: of one frame rate, robot and set of features.
        out: a folder that is not there yet. If anything is raised, it is left unfinished: use
            `lfr.artifacts.write_whole`.

    Returns:
        Counts: episodes, frames, and videos copied, cut and encoded.

    Raises:
        DataError: a part cannot be read or is of another kind, or what was written has errors.
    """
    parts = [part for part in parts if len(part.episodes)]
    if not parts:
        raise DataError("no episodes are left", file=out)
    try:
        sources = [Contents.open(part.path) for part in parts]
        for source in sources[1:]:
            _same_kind(sources[0], source)
        writer = _Assembly(out, sources, parts)
        counts = writer.write()
    except Unreadable as unreadable:
        raise _error(out, unreadable.finding) from None
    report = verify_dataset(out)
    if report.errors:
        raise _error(out, report.errors[0])
    return counts


def _error(path: Path, finding: Finding) -> DataError:
    return DataError(finding.message, file=path / finding.file, episode=finding.episode,
                     column=finding.column, found=finding.found,
                     expected=finding.expected)  # fmt: skip


def _same_kind(first: Contents, other: Contents) -> None:
    def kind(contents: Contents) -> dict[str, Any]:
        features = {
            f"features.{key}": {name: f.get(name) for name in ("dtype", "shape", "names")}
            for key, f in contents.features.items()
        }
        return {"fps": contents.fps, "robot_type": contents.info.get("robot_type"), **features}

    expected, found = kind(first), kind(other)
    for column in {**expected, **found}:
        if expected.get(column) != found.get(column):
            raise DataError(f"a dataset of another kind than {first.path}", file=other.path / INFO,
                            column=column, found=found.get(column),
                            expected=expected.get(column))  # fmt: skip


class _Assembly:
    """The new dataset while it is written."""

    def __init__(self, out: Path, sources: list[Contents], parts: Sequence[Part]) -> None:
        self.out, self.sources, self.parts = out, sources, parts
        self.info: dict[str, Any] = json.loads(json.dumps(sources[0].info))
        self.fps = sources[0].fps
        self.words: dict[str, int] = {}  # task -> its index, in the order of first use
        for source, part in zip(sources, parts, strict=True):
            outside = [e for e in part.episodes if not 0 <= e < len(source.episodes)]
            if outside:
                raise DataError("no such episode", file=source.path, episode=outside[0],
                                expected=f"0 to {len(source.episodes) - 1}")  # fmt: skip
        self.lengths = np.concatenate(
            [
                source.lengths[list(part.episodes)]
                for source, part in zip(sources, parts, strict=True)
            ]
        )

    def write(self) -> dict[str, int]:
        columns = self._rows()
        how: dict[str, int] = {"copied": 0, "cut": 0, "encoded": 0}
        for key in self.sources[0].pictures():
            columns |= self._videos(key, how)
        self._merge_video_info()
        frames, ends = int(self.lengths.sum()), np.cumsum(self.lengths)
        count = len(self.lengths)
        columns |= {
            "episode_index": np.arange(count),
            "dataset_from_index": ends - self.lengths,
            "dataset_to_index": ends,
            "meta/episodes/chunk_index": np.zeros(count, np.int64),
            "meta/episodes/file_index": np.zeros(count, np.int64),
        }
        self.info |= {
            "total_episodes": count,
            "total_frames": frames,
            "total_tasks": len(self.words),
            "splits": {"train": f"0:{count}"},
        }
        (self.out / "meta").mkdir(parents=True, exist_ok=True)
        _write_json(self.out / INFO, self.info)
        self._tasks()
        self._episodes(columns)
        return {"episodes": count, "frames": frames, **how}

    def _rows(self) -> dict[str, np.ndarray]:
        """Write the data files, one row group for each episode; where each episode is."""
        limit = (self.info.get("data_files_size_in_mb") or MEGABYTES) * 2**20
        per_chunk = int(self.info.get("chunks_size") or CHUNK)
        writer: pq.ParquetWriter | None = None
        files, size, places, start = 0, 0, [], 0
        try:
            for episode, rows in enumerate(self._rows_of_episodes()):
                rows = with_column(rows, "episode_index", np.full(len(rows), episode))
                rows = with_column(rows, "index", np.arange(start, start + len(rows)))
                if writer is None or size + rows.nbytes > limit:
                    if writer is not None:
                        writer.close()
                    path = self._path("data_path", files, per_chunk)
                    writer = pq.ParquetWriter(path, rows.schema, compression="snappy")
                    files, size = files + 1, 0
                writer.write_table(rows.cast(writer.schema), row_group_size=max(len(rows), 1))
                size, start = size + rows.nbytes, start + len(rows)
                places.append(divmod(files - 1, per_chunk))
        finally:
            if writer is not None:
                writer.close()
        chunk, file = np.array(places).T
        return {"data/chunk_index": chunk, "data/file_index": file}

    def _rows_of_episodes(self) -> Iterator[pa.Table]:
        schema = self.sources[0].data[0].schema_arrow
        for source, part in zip(self.sources, self.parts, strict=True):
            there, words = runs(source), task_words(source)
            run_of = dict(zip(there.episode.tolist(), range(len(there.episode)), strict=True))
            ends = np.cumsum(source.rows_of_files)
            open_file, table = -1, pa.table({})
            for episode in part.episodes:
                run = run_of.get(episode)
                length = int(source.lengths[episode])
                if run is None or there.length[run] != length:
                    raise DataError(
                        "another number of rows than the episode's length", file=source.path,
                        episode=episode, found=0 if run is None else int(there.length[run]),
                        expected=length,
                    )  # fmt: skip
                start = int(there.start[run])
                file = int(np.searchsorted(ends, start, side="right"))
                if file != open_file:
                    table = source.data[file].read(use_threads=False)
                    open_file = file
                begin = int(ends[file]) - source.rows_of_files[file]
                rows = table.slice(start - begin, length).select(schema.names)
                rows = rows.replace_schema_metadata(schema.metadata)
                tasks = [self._task(words[i]) for i in rows["task_index"].to_pylist()]
                yield with_column(rows, "task_index", np.array(tasks))

    def _task(self, words: str) -> int:
        return self.words.setdefault(words, len(self.words))

    def _videos(self, key: str, how: dict[str, int]) -> dict[str, np.ndarray]:
        """Write a camera's files, one for each stretch of neighbours; where each episode is."""
        clips: list[Clip] = []
        files: list[int] = []  # of each episode
        firsts: list[int] = []  # of each episode's frames, in its file
        for clip in self._clips(key):
            if clips and clips[-1].followed_by(clip):
                firsts.append(clips[-1].frames)
                clips[-1] = clips[-1].joined(clip)
            else:
                firsts.append(0)
                clips.append(clip)
            files.append(len(clips) - 1)
        per_chunk = int(self.info.get("chunks_size") or CHUNK)
        info = self.sources[0].features[key].get("info")
        for number, clip in enumerate(clips):
            path = self._path("video_path", number, per_chunk, video_key=key)
            how[write_clip(clip, path, self.fps, info)] += 1
        chunk, file = np.divmod(np.array(files), per_chunk)
        first = np.array(firsts)
        return {
            f"videos/{key}/chunk_index": chunk,
            f"videos/{key}/file_index": file,
            f"videos/{key}/from_timestamp": first / self.fps,
            f"videos/{key}/to_timestamp": (first + self.lengths) / self.fps,
        }

    def _clips(self, key: str) -> Iterator[Clip]:
        for source, part in zip(self.sources, self.parts, strict=True):
            chunk, file, start = (
                source.episode_column(f"videos/{key}/{name}")
                for name in ("chunk_index", "file_index", "from_timestamp")
            )
            for e in part.episodes:
                name = source.named("video_path", video_key=key, chunk_index=int(chunk[e]),
                                    file_index=int(file[e]))  # fmt: skip
                first = round(float(start[e]) * self.fps)
                yield Clip(source.path / name, first, int(source.lengths[e]))

    def _merge_video_info(self) -> None:
        """An encoder setting that the parts do not share is null, as in LeRobot's own merging."""
        for key in self.sources[0].pictures():
            infos = [source.features[key].get("info") or {} for source in self.sources]
            merged = {
                name: value if all(i.get(name) == value for i in infos) else None
                for name, value in infos[0].items()
            }
            if infos[0]:
                self.info["features"][key]["info"] = merged

    def _tasks(self) -> None:
        import pandas as pd

        index = pd.Index(list(self.words), name="task")
        table = pd.DataFrame({"task_index": list(self.words.values())}, index=index)
        table.to_parquet(self.out / TASKS)

    def _episodes(self, columns: dict[str, np.ndarray]) -> None:
        """Write meta/episodes and the statistics, from the rows that have been written."""
        kept = [
            source.episodes.take(pa.array(list(part.episodes), pa.int64()))
            for source, part in zip(self.sources, self.parts, strict=True)
        ]
        table = pa.concat_tables(kept, promote_options="default")
        for name, values in columns.items():
            table = with_column(table, name, values)
        written = Contents.open(self.out)
        stats: dict[str, dict[str, Any]] = {}
        for key in written.numeric():
            values = written.column(key)
            if not np.isfinite(values).all():
                continue  # verifying it refuses it
            stats[key] = {name: value.tolist() for name, value in dataset_stats(values).items()}
            for name, value in episode_stats(values, self.lengths).items():
                table = with_column(table, f"stats/{key}/{name}", pa.array(value.tolist()))
        for key in written.features:
            if key not in stats and (of_pictures := pooled_stats(table, key)):
                stats[key] = of_pictures
        _write_json(self.out / STATS, {key: stats[key] for key in written.features if key in stats})
        path = self.out / "meta/episodes/chunk-000/file-000.parquet"
        path.parent.mkdir(parents=True)
        pq.write_table(table, path, compression="snappy")

    def _path(self, template: str, number: int, per_chunk: int, **names: str) -> Path:
        chunk, file = divmod(number, per_chunk)
        name = self.sources[0].named(template, chunk_index=chunk, file_index=file, **names)
        path = self.out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def _write_json(path: Path, content: Any) -> None:
    text = json.dumps(content, indent=4, ensure_ascii=False, allow_nan=False)
    path.write_text(text, encoding="utf-8")
