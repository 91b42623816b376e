"""A dataset of chosen episodes of other datasets: what deleting, splitting and merging all are.

LeRobot 0.6.1's delete_episodes and split_dataset drop the columns of meta/episodes that it does not
know, and its statistics are averages of the episodes' (issues 2999 and 4156). Here every column is
kept, and every statistic is computed from the rows.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.curation.assembled_rows import write_rows
from lfr.curation.assembled_videos import shared_settings, write_videos
from lfr.curation.contents import EPISODES, INFO, STATS, TASKS, Contents, with_column
from lfr.curation.exact_stats import dataset_stats, pooled_stats, with_episode_stats
from lfr.curation.finding import as_error, readable, unreadable
from lfr.curation.meta_files import write_json, write_tasks
from lfr.curation.parts import Part, Source, open_parts
from lfr.curation.verify import verify_dataset
from lfr.errors import DataError


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
    chosen = [part for part in parts if len(part.episodes)]
    if not chosen:
        raise DataError("no episodes are left", file=parts[0].path if parts else out)
    sources = open_parts(chosen)
    with readable(sources[0].path):  # whose info.json all of it is named by
        counts = _write(sources, out)
    for finding in verify_dataset(out).errors[:1]:
        raise as_error(Path(), finding, f"what would be written is wrong: {finding.message}")
    return counts


def _write(sources: list[Source], out: Path) -> dict[str, int]:
    model = sources[0].contents
    info: dict[str, Any] = json.loads(json.dumps(model.info))
    how = {"copied": 0, "cut": 0, "encoded": 0}
    written = write_rows(out, sources)
    columns: dict[str, NDArray] = dict(written.places)
    for key in model.pictures():
        columns |= write_videos(out, sources, key, how)
        if settings := shared_settings(sources, key):
            info["features"][key]["info"] = settings
    lengths = np.concatenate([source.lengths for source in sources])
    count, frames, ends = len(lengths), int(lengths.sum()), np.cumsum(lengths)
    columns |= {
        "episode_index": np.arange(count),
        "dataset_from_index": ends - lengths,
        "dataset_to_index": ends,
        "meta/episodes/chunk_index": np.zeros(count, np.int64),
        "meta/episodes/file_index": np.zeros(count, np.int64),
    }
    info |= {
        "total_episodes": count,
        "total_frames": frames,
        "total_tasks": len(written.tasks),
        "splits": {"train": f"0:{count}"},
    }
    (out / "meta").mkdir(parents=True, exist_ok=True)
    write_json(out / INFO, info)
    write_tasks(out / TASKS, written.tasks)
    _write_episodes(out, sources, columns, lengths)
    return {"episodes": count, "frames": frames, **how}


def _write_episodes(
    out: Path, sources: list[Source], columns: dict[str, NDArray], lengths: NDArray[np.int64]
) -> None:
    """Write meta/episodes and the statistics, from the rows that have been written."""
    kept = [
        source.contents.episodes.take(pa.array(list(source.positions), pa.int64()))
        for source in sources
    ]
    with unreadable("schema", "columns of other types than in another dataset", pa.ArrowException,
                    file=EPISODES):  # fmt: skip
        table = pa.concat_tables(kept, promote_options="default")
    for name, values in columns.items():
        table = with_column(table, name, values)
    written = Contents.open(out)
    stats: dict[str, dict[str, Any]] = {}
    for key in written.numeric():
        values = written.column(key)
        if not np.isfinite(values).all():
            continue  # verifying it refuses it
        stats[key] = {name: value.tolist() for name, value in dataset_stats(values).items()}
        table = with_episode_stats(table, key, values, lengths)
    for key in written.features:
        if key not in stats and (of_pictures := pooled_stats(table, key)):
            stats[key] = of_pictures
    write_json(out / STATS, {key: stats[key] for key in written.features if key in stats})
    path = out / EPISODES / "chunk-000/file-000.parquet"
    path.parent.mkdir(parents=True)
    pq.write_table(table, path, compression="snappy")
