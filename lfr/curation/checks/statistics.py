"""meta/stats.json and the statistics of each episode, recomputed from the rows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfr.artifacts import parse_json
from lfr.curation.contents import EPISODES, PICTURES, STATS, Contents, Runs, runs
from lfr.curation.exact_stats import (
    NAMES,
    averaged,
    dataset_stats,
    episode_stats,
    pooled_stats,
)
from lfr.curation.finding import Finding, Severity, first, unreadable
from lfr.data.features import settings_of
from lfr.data.older import V20, V21
from lfr.data.stats import QUANTILES, Stats

AVERAGED = "averaged-quantiles"
# LeRobot adds float32 values up, so a mean is off by this part of the values' root mean square,
# and a variance, the difference of two such sums, by this part of the mean square.
TOLERANCE = 2e-5
# Its quantiles are read off a histogram of 5000 bins over the values' range.
BIN = 1e-3
# LeRobot 0.6.1's own deleting, splitting and merging number these anew and leave statistics of them
# as they were. No policy is normalized by them.
RENUMBERED = ("episode_index", "index", "task_index")


def check_statistics(contents: Contents) -> Iterator[Finding]:
    """Every statistic that is there is that of the rows; what LeRobot writes is all there."""
    stored = stored_stats(contents)
    there = runs(contents)
    averages: list[Finding] = []
    for key in contents.numeric():
        values = contents.column(key)
        if values.size == 0 or not np.isfinite(values).all():
            continue  # said where the values are checked
        if not isinstance(stored.get(key), dict):
            if stored:
                yield Finding("statistics", "no statistics of a feature", "warning", STATS,
                              column=key)  # fmt: skip
        elif contents.source.version != V21:  # where they are no more than the episodes'
            for finding in of_dataset(contents, key, stored[key], values):
                if finding.check == AVERAGED:
                    averages.append(finding)
                else:
                    yield finding
        yield from of_episodes(contents, key, values, there)
    if averages:  # of one cause, so in one line
        columns = ", ".join(str(finding.column) for finding in averages)
        yield replace(averages[0], column=columns, places=len(averages))
    for dtype in PICTURES:
        for key in contents.pictures(dtype):
            if isinstance(stored.get(key), dict):
                yield from of_pictures(contents, key, stored[key])
            elif stored:
                yield Finding("statistics", "no statistics of a feature", "warning", STATS,
                              column=key)  # fmt: skip


def names_in(version: str) -> tuple[str, ...]:
    """The statistics that LeRobot of this version writes."""
    return {V20: NAMES[:4], V21: NAMES[:5]}.get(version, NAMES)


def stored_stats(contents: Contents) -> Mapping[str, Any]:
    """What meta/stats.json holds; nothing where it is not there.

    Of v2.1, whose LeRobot puts them together itself: those of its episodes.

    Raises:
        Unreadable: it is cut off, or no JSON object.
    """
    if contents.source.version == V21:
        columns = contents.episodes.column_names
        there = [k for k in contents.features if any(c.startswith(f"stats/{k}/") for c in columns)]
        pictures = {key for dtype in PICTURES for key in contents.pictures(dtype)}
        with unreadable("statistics", "gaps or mixed shapes", TypeError, ValueError, file=EPISODES,
                        column="stats/"):  # fmt: skip
            return {k: pooled_stats(contents.episodes, k) if k in pictures else {} for k in there}
    file = contents.path / STATS
    if not file.is_file():
        return {}
    with unreadable("statistics", "cut off or no JSON object", ValueError, file=STATS):
        stored = parse_json(file.read_text(encoding="utf-8"))
        if not isinstance(stored, dict):
            raise ValueError(type(stored).__name__)
    return stored


def of_dataset(
    contents: Contents, key: str, stored: Mapping[str, Any], values: NDArray
) -> Iterator[Finding]:
    """A feature's statistics in meta/stats.json against its (N,) or (N, D) values."""
    rows = values.reshape(len(values), -1)
    exact = dataset_stats(values)
    known = names_in(contents.source.version)
    if missing := [name for name in known if name not in stored]:
        yield Finding("statistics", "statistics are missing", "warning", STATS, column=key,
                      found=", ".join(stored), expected=", ".join(missing))  # fmt: skip
    wrong: list[tuple[str, NDArray, NDArray]] = []  # name, found, which dimensions
    averages: list[tuple[str, NDArray, NDArray]] = []
    for name in (name for name in known if name in stored):
        found = _numbers(stored[name], exact[name].shape)
        if found is None:
            yield Finding("statistics", "another shape than the feature", file=STATS,
                          column=f"{key}/{name}", found=stored[name],
                          expected=f"{exact[name].size} numbers")  # fmt: skip
            continue
        slack = _slack(contents, exact["count"])
        off = ~_close(name, found[None], {n: v[None] for n, v in exact.items()}, slack)[0]
        if not off.any() or (
            name in QUANTILES and _is_quantile(found, rows, QUANTILES[name]).all()
        ):
            continue
        average = name in QUANTILES and _is_average(contents, key, name, found)
        (averages if average else wrong).append((name, found, off))
    kinds: tuple[tuple[str, str, Severity, list[tuple[str, NDArray, NDArray]]], ...] = (
        ("statistics", "not the statistics of the rows", _severity(key), wrong),
        (AVERAGED, "the mean of the episodes' quantiles, not a quantile of the rows "
         "(lerobot issue 4156)", "warning", averages),
    )  # fmt: skip
    for check, message, severity, those in kinds:
        if those:
            name, found, off = those[0]
            at, places = first(off)
            names = ", ".join(each for each, _, _ in those)
            yield Finding(check, f"{message} ({names})", severity, STATS,
                          column=f"{key}/{name}", found=float(found[at]),
                          expected=float(exact[name][at]), places=places)  # fmt: skip


def of_episodes(contents: Contents, key: str, values: NDArray, there: Runs) -> Iterator[Finding]:
    """A feature's statistics in meta/episodes against its values."""
    columns = [n for n in NAMES if f"stats/{key}/{n}" in contents.episodes.column_names]
    lengths = there.length
    if not columns or not np.array_equal(there.episode, np.arange(len(contents.episodes))):
        return  # rows and episodes do not match: said where they are counted
    exact = episode_stats(values, lengths, bounds=True)
    names, places, worst = [], np.zeros(len(lengths), bool), None
    for name in columns:
        column = f"stats/{key}/{name}"
        found = contents.episode_column(column)
        found = found.reshape(len(found), -1).astype(np.float64)
        if found.shape != exact[name].shape:
            yield Finding("statistics", "another shape than the feature", file=EPISODES,
                          column=column, found=found.shape[1:],
                          expected=exact[name].shape[1:])  # fmt: skip
            continue
        wrong = ~_close(name, found, exact, _slack(contents, exact["count"]))  # (E, D)
        if name in QUANTILES:  # LeRobot's are another definition's, read off a histogram
            slack = 1e-9 + BIN * (exact["max"] - exact["min"])
            above = found >= exact[f"{name}/low"] - slack
            wrong &= ~(above & (found <= exact[f"{name}/high"] + slack))
        if wrong.any():
            names.append(name)
            places |= wrong.any(axis=1)
            worst = worst or (column, found, wrong, exact[name])
    if worst is not None:
        column, found, wrong, expected = worst
        episode, at = (int(i) for i in np.argwhere(wrong)[0])
        yield Finding("statistics", f"not the statistics of the episode's rows "
                      f"({', '.join(names)})", _severity(key), EPISODES, episode, column,
                      found=float(found[episode, at]), expected=float(expected[episode, at]),
                      places=int(places.sum()),
                      episodes=tuple(np.flatnonzero(places).tolist()))  # fmt: skip


def _severity(key: str) -> Severity:
    return "warning" if key in RENUMBERED else "error"


def _slack(contents: Contents, count: NDArray) -> NDArray[np.float64]:
    """The relative precision of statistics of so many rows each.

    Before v3.0 float32 was added up one after the other, where each sum may round away half of its
    last bit.
    """
    return np.maximum(TOLERANCE, count * 2.0**-24 if contents.source.is_older else 0.0)


def _close(name: str, found: NDArray, exact: Stats, slack: NDArray) -> NDArray[np.bool_]:
    """(E, D) whether stored statistics are the exact ones, to the precision they are made in."""
    expected = exact[name]
    if name == "count":
        return found == expected
    square = exact["mean"] ** 2 + exact["std"] ** 2
    with np.errstate(invalid="ignore"):
        if name == "std":
            return np.abs(found**2 - expected**2) <= slack * square
        if name in QUANTILES:
            return np.abs(found - expected) <= 1e-9 + BIN * 1e-3 * (exact["max"] - exact["min"])
        scale = np.sqrt(square) if name == "mean" else np.abs(expected)
        return np.abs(found - expected) <= 1e-9 + slack * scale


def _is_quantile(found: NDArray, rows: NDArray, q: float) -> NDArray[np.bool_]:
    """(D,) whether a fraction q of the rows lies below `found`, to one row and one bin."""
    rows = rows.astype(np.float64)
    slack = BIN * (rows.max(axis=0) - rows.min(axis=0)) + 1e-9
    below = (rows < found - slack).mean(axis=0)
    up_to = (rows <= found + slack).mean(axis=0)
    return (below <= q + 1.5 / len(rows)) & (up_to >= q - 1.5 / len(rows))


def _is_average(contents: Contents, key: str, name: str, found: NDArray) -> bool:
    columns = contents.episodes.column_names
    if not {f"stats/{key}/{name}", f"stats/{key}/count"} <= set(columns):
        return False
    quantiles = contents.episode_column(f"stats/{key}/{name}").reshape(len(contents.episodes), -1)
    counts = contents.episode_column(f"stats/{key}/count").reshape(len(quantiles), -1)[:, :1]
    mean = averaged(quantiles, counts)
    return np.allclose(found, mean, rtol=1e-3, atol=1e-6)


def of_pictures(contents: Contents, key: str, stored: Mapping[str, Any]) -> Iterator[Finding]:
    """A camera's statistics: in [0, 1] and in order, and those of its episodes; none is decoded."""
    found: dict[str, NDArray[np.float64]] = {}
    for name in names_in(contents.source.version):
        numbers = _numbers(stored.get(name), None)
        if numbers is None or not np.isfinite(numbers).all():
            lacking = name in QUANTILES and name not in stored
            yield Finding("statistics", "no numbers", "warning" if lacking else "error", STATS,
                          column=f"{key}/{name}", found=stored.get(name))  # fmt: skip
            return
        found[name] = numbers
    if len({numbers.shape for name, numbers in found.items() if name != "count"}) > 1:
        yield Finding("statistics", "not as many numbers in each", file=STATS, column=key,
                      found={name: numbers.size for name, numbers in found.items()})  # fmt: skip
        return
    order = np.stack([found[n] for n in ("min", "q01", "q50", "q99", "max") if n in found])
    depth = settings_of(contents.features[key]).get("is_depth_map")
    outside = not depth and (order.min() < -1e-6 or order.max() > 1 + 1e-6)
    if outside or (np.diff(order, axis=0) < -1e-6).any():
        yield Finding("statistics", "pixels out of order or of [0, 1]", file=STATS, column=key,
                      found=order.tolist())  # fmt: skip
    columns = {n: f"stats/{key}/{n}" for n in ("min", "max", "mean", "count")}
    if not set(columns.values()) <= set(contents.episodes.column_names):
        return
    if lacking := max(contents.episodes[column].null_count for column in columns.values()):
        yield Finding("statistics", "episodes without statistics of their pictures", "warning",
                      EPISODES, column=f"stats/{key}", places=lacking)  # fmt: skip
        return
    with unreadable("statistics", "gaps or mixed shapes", TypeError, ValueError, file=EPISODES,
                    column=f"stats/{key}"):  # fmt: skip
        per = {n: _nested(contents.episodes[c].to_pylist()) for n, c in columns.items()}
    expected = {"min": per["min"].min(axis=0), "max": per["max"].max(axis=0),
                "mean": averaged(per["mean"], per["count"][:, :1])}  # fmt: skip
    for name, numbers in expected.items():
        same = found[name].shape == numbers.shape
        if not (same and np.allclose(found[name], numbers, rtol=1e-4, atol=1e-4)):
            yield Finding("statistics", "not those of its episodes", file=STATS,
                          column=f"{key}/{name}", found=found[name],
                          expected=numbers.tolist())  # fmt: skip


def _numbers(value: Any, shape: tuple[int, ...] | None) -> NDArray[np.float64] | None:
    """Flat numbers of JSON's lists; None where they are no numbers or not as many."""
    try:
        numbers = np.asarray(value, np.float64).ravel()
    except (TypeError, ValueError):
        return None
    return numbers if shape is None or numbers.shape == shape else None


def _nested(rows: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(rows, np.float64)
    return array.reshape(len(array), -1)
