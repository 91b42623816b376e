"""Episodes, rows and tasks: as many everywhere, and each where it is said to be."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from lfr.curation.contents import EPISODES, INFO, TASKS, Contents, at_episodes, runs
from lfr.curation.finding import Finding, Unreadable, first


def check_counts(contents: Contents) -> Iterator[Finding]:
    """info.json, meta/episodes and the data files agree on how much there is."""
    rows, episodes = sum(contents.rows_of_files), len(contents.episodes)
    totals = {"total_frames": rows, "total_episodes": episodes}
    with suppress(Unreadable):  # its own check says so
        totals["total_tasks"] = len(task_words(contents))
    if contents.source.is_older:
        size = contents.info.get("chunks_size")
        chunks = -(-episodes // size) if isinstance(size, int) and size > 0 else None
        older = {"total_chunks": chunks, "total_videos": episodes * len(contents.pictures())}
        totals |= {name: total for name, total in older.items() if name in contents.info}
    for column, expected in totals.items():
        found = contents.info.get(column)
        if found != expected:
            yield Finding("counts", "info.json counts another number than there is", file=INFO,
                          column=column, found=found, expected=expected)  # fmt: skip
    yield from _splits(contents, episodes)
    if not episodes or not rows:
        yield Finding("counts", "nothing in it", file=EPISODES, found=f"{episodes} episodes, "
                      f"{rows} rows", expected="at least one of each")  # fmt: skip
        return
    index = contents.episode_column("episode_index")
    if (wrong := index != np.arange(episodes)).any():
        at, where = at_episodes(wrong)
        yield Finding("episode-index", "episodes out of order, missing, or there twice",
                      file=EPISODES, column="episode_index", found=int(index[at]), expected=at,
                      **{**where, "episode": None})  # fmt: skip
    yield from _lengths(contents)
    yield from _from_to(contents)
    yield from _files(contents)


def task_words(contents: Contents) -> dict[int, str]:
    """The task's words by task_index, of meta/tasks.parquet."""
    table = contents.rows_of(contents.path / TASKS)
    words = next((n for n in ("task", "__index_level_0__") if n in table.column_names), None)
    if words is None or "task_index" not in table.column_names:
        raise Unreadable(Finding("schema", "not the columns of tasks", file=TASKS,
                                 found=table.column_names,
                                 expected="task_index, task"))  # fmt: skip
    return dict(zip(table["task_index"].to_pylist(), table[words].to_pylist(), strict=True))


def _splits(contents: Contents, episodes: int) -> Iterator[Finding]:
    splits = contents.info.get("splits") or {}
    if not isinstance(splits, dict):
        yield Finding(
            "counts", "splits that are no table", file=INFO, column="splits", found=splits
        )
        return
    for name, split in splits.items():
        start, _, end = str(split).partition(":")
        if not (start.isdigit() and end.isdigit() and int(start) <= int(end) <= episodes):
            yield Finding("counts", "a split of episodes that are not there", file=INFO,
                          column=f"splits.{name}", found=split,
                          expected=f"within 0:{episodes}")  # fmt: skip


def _lengths(contents: Contents) -> Iterator[Finding]:
    lengths, there = contents.lengths, runs(contents)
    episodes = len(lengths)
    known = (there.episode >= 0) & (there.episode < episodes)
    if not known.all():
        _, where = contents.at_rows(there.start[~known])
        yield Finding("counts", "rows of an episode that meta/episodes does not have", **where,
                      column="episode_index", found=where["episode"],
                      expected=f"0 to {episodes - 1}")  # fmt: skip
    found = np.bincount(there.episode[known], weights=there.length[known], minlength=episodes)
    if (wrong := found != lengths).any():
        at, where = at_episodes(wrong)
        yield Finding("counts", "another number of rows than the episode's length", file=EPISODES,
                      column="length", found=int(found[at]), expected=int(lengths[at]),
                      **where)  # fmt: skip
    if (wrong := lengths < 1).any():
        at, where = at_episodes(wrong)
        yield Finding("counts", "an empty episode", file=EPISODES, column="length",
                      found=int(lengths[at]), expected="at least 1", **where)  # fmt: skip


def _from_to(contents: Contents) -> Iterator[Finding]:
    ends = np.cumsum(contents.lengths)
    for column, expected in (
        ("dataset_from_index", ends - contents.lengths),
        ("dataset_to_index", ends),
    ):
        found = contents.episode_column(column)
        if (wrong := found != expected).any():
            at, where = at_episodes(wrong)
            yield Finding("counts", "rows that are another episode's", file=EPISODES,
                          column=column, found=int(found[at]), expected=int(expected[at]),
                          **where)  # fmt: skip


def _files(contents: Contents) -> Iterator[Finding]:
    """LeRobot reads an episode from the file that meta/episodes names."""
    names = [contents.relative(file) for file in contents.data_files]
    there, ends = runs(contents), np.cumsum(contents.rows_of_files)
    said = np.full(len(contents.episodes), -1)
    for name, episodes in contents.placed_in("data").items():
        said[episodes] = names.index(name) if name in names else -1
    known = (there.episode >= 0) & (there.episode < len(said))
    file_of_run = np.searchsorted(ends, there.start[known], side="right")
    last = np.searchsorted(ends, (there.start + there.length - 1)[known], side="right")
    of_run = there.episode[known]
    expected = said[of_run]
    wrong = ((file_of_run != expected) | (last != expected)) & (expected >= 0)
    if wrong.any():
        at, places = first(wrong)
        yield Finding("counts", "rows in another file than meta/episodes says",
                      file=names[file_of_run[at]], episode=int(of_run[at]),
                      column="data/file_index", row=int(there.start[known][at]),
                      found=names[last[at] if file_of_run[at] == expected[at] else file_of_run[at]],
                      expected=names[expected[at]], places=places,
                      episodes=tuple(np.unique(of_run[wrong]).tolist()))  # fmt: skip
