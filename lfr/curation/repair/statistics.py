"""meta/stats.json and the statistics in meta/episodes, computed anew where they are wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.curation.checks.counts import task_words
from lfr.curation.checks.statistics import (
    AVERAGED,
    of_dataset,
    of_episodes,
    of_pictures,
    stored_stats,
)
from lfr.curation.contents import EPISODES, PICTURES, STATS, Contents, runs
from lfr.curation.exact_stats import NAMES, dataset_stats, pooled_stats, with_episode_stats
from lfr.curation.finding import Unreadable
from lfr.curation.meta_files import write_json
from lfr.curation.repair.draft import Draft, Unmendable
from lfr.curation.repair.rows import episode_lengths


def mend_statistics(draft: Draft) -> None:
    """Compute statistics anew: of numbers from the rows, of pictures from the episodes'.

    Raises:
        Unmendable: the rows are not certain, or not those that meta/episodes counts.
    """
    contents = draft.contents()
    lengths = episode_lengths(contents)
    if not np.array_equal(contents.lengths, lengths):
        raise Unmendable  # said where the episodes are mended
    try:
        stored = dict(stored_stats(contents))
    except Unreadable:
        stored = {}
    renumbered = {"index", "frame_index", "episode_index"}
    if set(contents.column("task_index").ravel().tolist()) <= set(task_words(contents)):
        renumbered.add("task_index")  # as LeRobot's own editing does
    keys = []
    for key in contents.numeric():
        try:
            values = contents.column(key)
        except Unreadable:
            continue  # said where the values are checked
        if not values.size or not np.isfinite(values).all():
            draft.not_mended(f"statistics of {key}: not all of it is finite")
        elif key not in renumbered and _changed_since(contents, key, values, stored):
            draft.not_mended(
                f"statistics of {key}: those in meta/stats.json and in meta/episodes agree with "
                "each other and not with the rows, which have changed since; if the rows are "
                "right, remove meta/stats.json and mend again"
            )
        else:
            keys.append(key)
    _mend_episodes(draft, contents, lengths, keys)
    _mend_dataset(draft, draft.contents(), stored, keys)


def _changed_since(contents: Contents, key: str, values: NDArray, stored: dict[str, Any]) -> bool:
    """Whether rows have changed since both kinds of statistics were made of them."""
    before = stored.get(key)
    if not isinstance(before, dict) or not _wrong_episodes(contents, key, values):
        return False
    if all(f.check == AVERAGED for f in of_dataset(contents, key, before, values)):
        return False
    try:
        pooled = pooled_stats(contents.episodes, key)
        names = [name for name in ("min", "max", "mean", "std") if name in pooled]
        told = [np.ravel(np.asarray(before.get(name), np.float64)) for name in names]
        same = [np.allclose(t, np.ravel(pooled[n]), rtol=1e-4, atol=1e-6)
                for t, n in zip(told, names, strict=True)]  # fmt: skip
    except (ValueError, TypeError):  # no numbers, or not as many
        return False
    return bool(same) and all(same)


def _mend_episodes(
    draft: Draft, contents: Contents, lengths: NDArray[np.int64], keys: list[str]
) -> None:
    """Only of episodes that have statistics, or whose rows of meta/episodes are new."""
    table = contents.episodes
    has = any(name.startswith("stats/") for name in table.column_names)
    if not has and EPISODES not in str(draft.changed):
        return
    mended, places = [], 0
    for key in keys:
        values = contents.column(key)
        wrong = _wrong_episodes(contents, key, values)
        if wrong:
            table = _with_stats(table, key, values, lengths)
            mended.append(key)
            places = max(places, wrong)
    if not mended:
        return
    start = 0
    for file in contents.episode_files:
        name, count = contents.relative(file), contents.opened(file).metadata.num_rows
        with draft.replaced(name) as new:
            pq.write_table(table.slice(start, count), new, compression="snappy")
        start += count
    name = contents.relative(contents.episode_files[0])
    name = name if len(contents.episode_files) == 1 else EPISODES
    draft.mended(name, f"statistics of {', '.join(mended)}", places)


def _wrong_episodes(contents: Contents, key: str, values: NDArray) -> int:
    """How many episodes have other statistics than their rows, or lack some."""
    columns = [f"stats/{key}/{name}" for name in NAMES]
    if not set(columns) <= set(contents.episodes.column_names):
        return len(contents.episodes)
    lacking = max(contents.episodes[column].null_count for column in columns)
    if lacking:
        return lacking
    try:
        found = of_episodes(contents, key, values, runs(contents))
        return max((finding.places for finding in found), default=0)
    except (Unreadable, ValueError, TypeError):  # no numbers
        return len(contents.episodes)


def _with_stats(table: pa.Table, key: str, values: NDArray, lengths: NDArray) -> pa.Table:
    try:
        return with_episode_stats(table, key, values, lengths)
    except (pa.ArrowException, ValueError):  # columns of another type
        columns = [f"stats/{key}/{name}" for name in NAMES]
        table = table.drop_columns([name for name in columns if name in table.column_names])
        return with_episode_stats(table, key, values, lengths)


def _mend_dataset(
    draft: Draft, contents: Contents, stored: dict[str, Any], keys: list[str]
) -> None:
    stats: dict[str, Any] = dict(stored)
    averages: list[str] = []
    for key in keys:
        values = contents.column(key)
        before = stored.get(key)
        found = list(of_dataset(contents, key, before, values)) if isinstance(before, dict) else []
        if found or not isinstance(before, dict):
            stats[key] = {name: value.tolist() for name, value in dataset_stats(values).items()}
        if found and all(finding.check == AVERAGED for finding in found):
            averages.append(key)
    for key in [k for k in contents.features if k not in contents.numeric()]:
        if (pooled := _pooled(draft, contents, key, stored.get(key))) is not None:
            stats[key] = pooled
    mended = [key for key in stats if stats[key] is not stored.get(key)]
    if not mended:
        return
    known = [key for key in contents.features if key in stats]
    others = [key for key in stats if key not in known]
    order = [*stored, *(key for key in known if key not in stored)] if stored else known + others
    with draft.replaced(STATS) as new:
        write_json(new, {key: stats[key] for key in order}, allow_nan=True)
    for what, keys in (
        ("quantiles that were means of the episodes'", averages),
        ("written anew", [k for k in mended if k not in averages and k not in stored]),
        ("computed anew", [k for k in mended if k not in averages and k in stored]),
    ):
        if keys:
            draft.mended(STATS, f"{what}: {', '.join(keys)}", len(keys), "feature")


def _wrong_pictures(contents: Contents, key: str, stats: dict[str, Any]) -> bool:
    return any(finding.file == STATS for finding in of_pictures(contents, key, stats))


def _pooled(draft: Draft, contents: Contents, key: str, before: Any) -> dict[str, Any] | None:
    """Of pictures, and of features of more dimensions: what comes in place of what is there."""
    picture = contents.features[key].get("dtype") in PICTURES
    if isinstance(before, dict) and not (picture and _wrong_pictures(contents, key, before)):
        return None
    pooled = pooled_stats(contents.episodes, key)
    if not pooled or (picture and _wrong_pictures(contents, key, pooled)):
        if picture:
            draft.not_mended(
                f"statistics of {key}: those of its episodes are not all there, or not of "
                "pictures, and no picture is decoded for them"
            )
        return None
    return pooled
