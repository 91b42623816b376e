"""Values that cannot be: not finite, out of their range, constant, frozen, far from all others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lfr.curation.checks.ranges import bounds
from lfr.curation.contents import (
    DEFAULT_FEATURES,
    EPISODES,
    NOT_NUMBERS,
    Contents,
    Runs,
    at_episodes,
    runs,
)
from lfr.curation.finding import Finding
from lfr.data.episode import DONE, REWARD, SUCCESS
from lfr.data.features import names_of, shape_of

SLACK = 1e-3  # beyond a range: rotations are orthogonal to float32's precision, not exactly
# A value this many times as far from the median as the middle 98 % reach is a spike.
SPIKE = 100.0
# It gets there at once, half of that way in a step, and back within so many rows: a cube that falls
# over does not.
AT_ONCE, LONGEST = 0.5, 10
SELDOM = 0.1  # share of episodes: where more fail, failures are meant to be there


def check_values(contents: Contents) -> Iterator[Finding]:
    """Every column of numbers, one after the other."""
    there = runs(contents)
    still = np.ones(len(there.start), bool)  # episodes in which nothing observed has moved
    observed = False
    if not len(there.start):
        return  # said where the rows are counted
    yield from _tensors(contents)
    for key in contents.numeric():
        values = contents.column(key)
        rows = values.reshape(len(values), -1)
        expected = contents.features[key]["shape"][0]
        if rows.shape[1] != expected:
            yield Finding("shape", "another shape than info.json says", file="data", column=key,
                          found=rows.shape[1:], expected=(expected,))  # fmt: skip
            continue
        finite = np.isfinite(rows) if rows.dtype.kind == "f" else np.ones(rows.shape, bool)
        bad = np.asarray(~finite.all(axis=1))
        if bad.any():
            at, where = contents.at_rows(bad)
            yield Finding("not-finite", "NaN or infinite", **where, column=key,
                          found=rows[at].tolist(), expected="finite numbers")  # fmt: skip
        if key in DEFAULT_FEATURES or not len(rows):
            continue
        names = _names(contents.features[key], key, rows.shape[1])
        yield from _ranges(contents, key, names, rows)
        if key not in (DONE, SUCCESS, REWARD) and rows.dtype.kind == "f" and len(rows) > 1:
            yield from _constant(key, names, rows)
            if not bad.any():
                yield from _spikes(contents, names, rows, there)
        if key.startswith("observation."):
            observed = True
            still &= _still(rows, there)
    if observed and (still & (there.length > 1)).any():
        _, where = contents.at_rows(there.start[still & (there.length > 1)])
        yield Finding("frozen", "nothing that is observed moves", "warning", **where)
    yield from _outcomes(contents, there)


def _tensors(contents: Contents) -> Iterator[Finding]:
    """Features of more dimensions than one, element by element."""
    for key, feature in contents.features.items():
        if feature.get("dtype") in NOT_NUMBERS or len(shape_of(feature)) < 2:
            continue
        column = contents.table([key])[key].combine_chunks()
        count = len(column)
        while isinstance(column, pa.ExtensionArray):
            column = column.storage
        while pa.types.is_nested(column.type) and not pa.types.is_struct(column.type):
            column = column.flatten()
        if not (pa.types.is_floating(column.type) and len(column)):
            continue
        bad = ~np.isfinite(column.to_numpy(zero_copy_only=False))
        if bad.any() and len(bad) % count == 0:
            _, where = contents.at_rows(bad.reshape(count, -1).any(axis=1))
            yield Finding("not-finite", "NaN or infinite", **where, column=key,
                          expected="finite numbers")  # fmt: skip


def _names(feature: dict[str, Any], key: str, size: int) -> list[str]:
    """What each dimension is called, `action.dx`, for the findings."""
    names = names_of(feature)
    if len(names) == size > 1:
        return [f"{key}.{name}" for name in names]
    return [key] if size == 1 else [f"{key}[{i}]" for i in range(size)]


def _ranges(contents: Contents, key: str, names: list[str], rows: NDArray) -> Iterator[Finding]:
    robot = str(contents.info.get("robot_type") or "")
    for i, (low, high) in bounds(key, contents.features, robot).items():
        if i >= len(names):
            continue  # more names than dimensions: said where the schema is checked
        column = rows[:, i]
        wrong = (column < low - SLACK) | (column > high + SLACK)
        if wrong.any():
            at, where = contents.at_rows(wrong)
            yield Finding("range", "out of its range", **where, column=names[i],
                          found=float(column[at]), expected=f"{low:g} to {high:g}")  # fmt: skip


def _constant(key: str, names: list[str], rows: NDArray) -> Iterator[Finding]:
    for i in np.flatnonzero((rows == rows[0]).all(axis=0)):
        yield Finding("constant", "the same in every row", "warning", "data", column=names[i],
                      found=float(rows[0, i]))  # fmt: skip


def _spikes(contents: Contents, names: list[str], rows: NDArray, there: Runs) -> Iterator[Finding]:
    low, middle, high = np.quantile(rows, [0.01, 0.5, 0.99], axis=0, method="nearest")
    span = np.maximum(high - middle, middle - low).astype(np.float64)
    far = (np.abs(rows - middle) > SPIKE * span) & (span > 0)
    for i in np.flatnonzero(far.any(axis=0)):
        brief = _brief(rows[:, i], far[:, i], AT_ONCE * SPIKE * span[i], there)
        if not len(brief):
            continue
        at, where = contents.at_rows(brief)
        yield Finding("spike", "far from all other values", "warning", **where, column=names[i],
                      found=float(rows[at, i]),
                      expected=f"98 % are in {low[i]:g} to {high[i]:g}")  # fmt: skip


def _brief(values: NDArray, far: NDArray[np.bool_], leap: float, there: Runs) -> NDArray[np.int64]:
    """Rows of values (N,) that leap away and back in their episode: of stretches of `far` rows."""
    leaps = np.abs(np.diff(values, prepend=values[:1], append=values[-1:])) > leap  # into and out
    edge = np.zeros(len(values) + 1, bool)
    edge[there.start] = edge[-1] = True
    found = np.flatnonzero(far)
    first = found[edge[found] | ~np.append(False, far[:-1])[found]]
    last = found[edge[found + 1] | ~np.append(far[1:], False)[found]]
    into, out = leaps[first] | edge[first], leaps[last + 1] | edge[last + 1]
    short = last - first < LONGEST
    ends = (edge[first] | edge[last + 1]) & (last > first)  # a whole stretch at an episode's end
    chosen = [np.arange(a, b + 1) for a, b in zip(first, last, strict=True)]
    kept = np.flatnonzero(into & out & short & ~ends)
    return np.concatenate([chosen[k] for k in kept]) if len(kept) else found[:0]


def _still(rows: NDArray, there: Runs) -> NDArray[np.bool_]:
    """(R,) whether a column is the same in all rows of an episode."""
    same = np.ones(len(rows), bool)
    same[1:] = (rows[1:] == rows[:-1]).all(axis=1)
    same[there.start] = True
    return np.logical_and.reduceat(same, there.start)


def _outcomes(contents: Contents, there: Runs) -> Iterator[Finding]:
    """next.done and next.success against the episodes' ends and their column `success`."""
    if DONE in contents.features:
        done, last = contents.column(DONE).astype(bool).ravel(), there.start + there.length - 1
        early = done.copy()
        early[last] = False
        for chosen, message, found in (
            (early, "done before the episode's end", True),
            (_only(last, len(done)) & ~done, "not done at the episode's end", False),
        ):
            if chosen.any():
                _, where = contents.at_rows(chosen)
                yield Finding("done", message, "error" if found else "warning", **where,
                              column=DONE, found=found, expected=not found)  # fmt: skip
    if SUCCESS in contents.features:
        any_success = np.logical_or.reduceat(
            contents.column(SUCCESS).astype(bool).ravel(), there.start
        )
        failed = ~any_success
        if failed.all():
            yield Finding("success", "no successful episode", "warning", "data", column=SUCCESS,
                          found=f"0 of {len(any_success)}")  # fmt: skip
        elif 0 < failed.mean() <= SELDOM:
            _, where = contents.at_rows(there.start[failed])
            yield Finding("success", "fails, as hardly any other episode does", "warning", **where,
                          column=SUCCESS, found=f"{failed.sum()} of {len(failed)}")  # fmt: skip
        said = _said(contents)
        if len(said) == len(any_success):
            wrong = np.array(
                [s is not None and s != a for s, a in zip(said, any_success, strict=True)]
            )
            if wrong.any():
                at, where = at_episodes(wrong)
                yield Finding("success", "another outcome than its rows have", file=EPISODES,
                              column="success", found=said[at], expected=bool(any_success[at]),
                              **where)  # fmt: skip


def _said(contents: Contents) -> list[bool | None]:
    """The column `success` of meta/episodes; None where it has a gap, as after merging."""
    episodes = contents.episodes
    if "success" not in episodes.column_names:
        return []
    column = episodes["success"]
    return column.to_pylist() if pa.types.is_boolean(column.type) else []


def _only(rows: NDArray, count: int) -> NDArray[np.bool_]:
    chosen = np.zeros(count, bool)
    chosen[rows] = True
    return chosen
