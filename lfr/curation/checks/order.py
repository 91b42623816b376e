"""Rows in their order: indices, tasks, and time without gaps or jumps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.counts import task_words
from lfr.curation.contents import EPISODES, INFO, TASKS, Contents, at_episodes, runs
from lfr.curation.finding import Finding

TOLERANCE_S = 1e-4  # LeRobot's tolerance_s, beyond which it refuses to read a frame


def check_order(contents: Contents) -> Iterator[Finding]:
    """index, episode_index and frame_index count up."""
    there = runs(contents)
    rows = int(there.length.sum())
    yield from _compare(contents, "index", contents.column("index"), np.arange(rows))
    frames = np.arange(rows) - there.of_rows(there.start)
    yield from _compare(contents, "frame-index", contents.column("frame_index"), frames)
    if (wrong := np.diff(there.episode) <= 0).any():
        at = int(wrong.argmax())
        _, where = contents.at_rows(there.start[1:][wrong])
        yield Finding("episode-index", "an episode in pieces, or before another one", **where,
                      column="episode_index", found=int(there.episode[at + 1]),
                      expected=f"above {there.episode[at]}")  # fmt: skip


def check_time(contents: Contents) -> Iterator[Finding]:
    """Each episode's timestamps start at 0 and rise by 1 / fps."""
    there, seconds = runs(contents), contents.column("timestamp").astype(np.float64)
    if seconds.ndim > 1:
        seconds = seconds[:, 0]
    starts = np.zeros(len(seconds), bool)
    starts[there.start] = True
    # timestamps are float32: hours into an episode they are this coarse
    tolerance = np.maximum(TOLERANCE_S, 2 * np.spacing(seconds.astype(np.float32)))
    steps = np.diff(seconds, prepend=0.0)
    expected = np.where(starts, 0.0, 1 / contents.fps)
    found = np.where(starts, seconds, steps)
    wrong = ~(np.abs(found - expected) <= tolerance)
    step = float(np.median(found[~starts])) if not starts.all() else 0.0
    if (wrong | starts).all() and (np.abs(found - step) <= tolerance)[~starts].all() and step > 0:
        yield Finding("fps", "rows at another rate than info.json says", file=INFO, column="fps",
                      found=round(1 / step, 3), expected=contents.fps)  # fmt: skip
        return
    for check, message, chosen in (
        ("time-start", "an episode that does not start at 0 s", wrong & starts),
        ("gap-in-time", "a gap in time", wrong & ~starts & (found > expected)),
        ("jump-in-time", "time that stands still or goes back", wrong & ~starts
         & ~(found > expected)),
    ):  # fmt: skip
        if chosen.any():
            at, where = contents.at_rows(chosen)
            before = 0.0 if starts[at] else float(seconds[at - 1])
            yield Finding(check, message, **where, column="timestamp", found=float(seconds[at]),
                          expected=before + float(expected[at]))  # fmt: skip
    drift = np.abs(seconds - contents.column("frame_index") / contents.fps) > 10 * tolerance
    if drift.any() and not wrong.any():  # each step within the tolerance, their sum not
        at, where = contents.at_rows(drift)
        expected_s = float(contents.column("frame_index")[at] / contents.fps)
        yield Finding("gap-in-time", "time that drifts away from frame_index / fps", **where,
                      column="timestamp", found=float(seconds[at]),
                      expected=expected_s)  # fmt: skip


def check_tasks(contents: Contents) -> Iterator[Finding]:
    """Every row's task has words, and the episode lists them."""
    words, index = task_words(contents), contents.column("task_index")
    if sorted(words) != list(range(len(words))):
        yield Finding("tasks", "indices that do not count up from 0", file=TASKS,
                      column="task_index", found=sorted(words))  # fmt: skip
    for number, text in words.items():
        what = "no words" if not str(text).strip() else "control characters in its words"
        if what == "no words" or not all(c.isprintable() or c in "\n\t" for c in str(text)):
            those = np.unique(contents.column("episode_index")[index == number])
            yield Finding("tasks", f"a task with {what}", "warning", TASKS, column="task",
                          found=f"task {number}: {text!r}",
                          episodes=tuple(those.tolist()))  # fmt: skip
    if len(set(words.values())) != len(words):
        yield Finding("tasks", "the same words twice", "warning", TASKS, column="task")
    unknown = ~np.isin(index, list(words))
    if unknown.any():
        at, where = contents.at_rows(unknown)
        yield Finding("tasks", "a task without words", **where, column="task_index",
                      found=int(index[at]), expected=sorted(words))  # fmt: skip
        return
    if "tasks" not in contents.episodes.column_names:
        yield Finding("schema", "a column is missing", file=EPISODES, column="tasks")
        return
    listed = contents.episodes["tasks"].to_pylist()
    there, wrong = runs(contents), []
    pairs = np.unique(np.stack([contents.column("episode_index"), index], axis=1), axis=0)
    done: dict[int, set[str]] = {}
    for episode, task in pairs.tolist():
        done.setdefault(episode, set()).add(words[task])
    for episode in sorted(set(there.episode.tolist())):
        if 0 <= episode < len(listed) and set(listed[episode] or ()) != done[episode]:
            wrong.append(episode)
    if wrong:
        at, where = at_episodes(np.array(wrong))
        yield Finding("tasks", "other tasks than its rows have", file=EPISODES, column="tasks",
                      found=listed[at], expected=sorted(done[at]), **where)  # fmt: skip


def _compare(
    contents: Contents, check: str, found: NDArray, expected: NDArray
) -> Iterator[Finding]:
    if (wrong := found != expected).any():
        at, where = contents.at_rows(wrong)
        yield Finding(check, "rows out of order, missing, or there twice", **where,
                      column=check.replace("-", "_"), found=int(found[at]),
                      expected=int(expected[at]))  # fmt: skip
