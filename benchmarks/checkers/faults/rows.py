"""Faults of the rows: values that cannot be, rows out of order, times that are not 1 / fps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from benchmarks.checkers.bases import TOUCH
from benchmarks.checkers.dataset_copy import DatasetCopy
from benchmarks.checkers.faults.fault import ROW, Fault, K, Plant, at

NOT_FINITE = "nan|inf|finite|null|missing|gap"
IN_TIME = "time|monoton|gap|drop|jitter|tolerance|grid|fps|rate|drift|jump|cadence|interval"
IN_ORDER = "frame|index|order|gap|length|count|row|miss|dup|drop|monoton|time|backward"


def _one(key: str, value: float, *dimension: int) -> Plant:
    return lambda copy: copy.change(key, (at()(copy), *dimension), value)


def _as_lists(change: Callable[[list[Any]], object]) -> Plant:
    """A change of the action as lists of any length."""

    def plant(copy: DatasetCopy) -> None:
        rows = copy.rows["action"].to_pylist()
        rows[at()(copy)] = change(rows[at()(copy)])
        place = copy.rows.column_names.index("action")
        array = pa.array(rows, pa.list_(pa.float32()))
        copy.rows = copy.rows.set_column(place, "action", array)

    return plant


def _beyond(copy: DatasetCopy) -> None:
    start = at(20)(copy)
    copy.change("action", (slice(start, start + 6), 0), 2.0)
    copy.restat("action")


def _reordered(order: Callable[[NDArray, DatasetCopy], NDArray]) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        rows = np.arange(copy.rows.num_rows)
        copy.rows = copy.rows.take(pa.array(order(rows, copy)))

    return plant


def _two_swapped(rows: NDArray, copy: DatasetCopy) -> NDArray:
    row = at()(copy)
    rows[[row, row + 1]] = row + 1, row
    return rows


def _episodes_swapped(rows: NDArray, copy: DatasetCopy) -> NDArray:
    one, other = copy.span(K), copy.span(K + 1)
    rows[one.start : other.stop] = np.r_[other, one]
    return rows


def _lost(copy: DatasetCopy) -> None:
    """A row is lost, and all is counted anew; the video has its frame still."""
    whole = [np.r_[copy.span(e)] for e in range(copy.episodes.num_rows)]
    parts = [np.delete(part, ROW) if e == K else part for e, part in enumerate(whole)]
    copy.rebuild(parts, range(len(parts)), whole)


def _renumbered(key: str, change: Callable[[NDArray, slice], object]) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        values = copy.values(key)
        change(values, copy.span(K))
        copy.put(key, values)
        copy.restat(key)

    return plant


def _called_57(copy: DatasetCopy) -> None:
    numbers = copy.of_episodes("episode_index")
    numbers[K] = 57
    copy.put_of_episodes("episode_index", numbers)
    _renumbered("episode_index", lambda v, span: v.__setitem__(span, 57))(copy)


def _times(change: Callable[[NDArray], NDArray]) -> Plant:
    """A change of one episode's timestamps, with statistics to match."""
    return _renumbered("timestamp", lambda v, span: v.__setitem__(span, change(v[span])))


def _jittered(t: NDArray) -> NDArray:
    by = np.random.default_rng(1).uniform(-0.1, 0.1, len(t)) / 20
    return t + np.where(t > 0, by, 0)


def _at_row(t: NDArray, value: float) -> NDArray:
    return np.where(np.arange(len(t)) == ROW, value, t)


def _epoch(copy: DatasetCopy) -> None:
    copy.put("timestamp", (copy.values("timestamp") + 1.7e9).astype(np.float32))
    copy.restat("timestamp")


def _fps(fps: float) -> Plant:
    return lambda copy: copy.info.update(fps=fps)


FAULTS = {
    "nan_action": Fault("values", _one("action", np.nan, 2), NOT_FINITE),
    "nan_state": Fault("values", _one("observation.state", np.nan, 2), NOT_FINITE),
    "nan_2d": Fault("values", _one(TOUCH, np.nan, 1, 2), NOT_FINITE, "arm2d"),
    "inf_action": Fault("values", _one("action", np.inf, 2), NOT_FINITE),
    "nan_reward": Fault("values", _one("next.reward", np.nan), NOT_FINITE),
    "nan_timestamp": Fault("values", _one("timestamp", np.nan), f"{NOT_FINITE}|time"),
    "null_action": Fault("values", _as_lists(lambda row: None), f"{NOT_FINITE}|none"),
    "ragged_action": Fault(
        "values", _as_lists(lambda row: row[:6]), "shape|length|ragged|dim|size|lists"
    ),
    "action_outside_bounds": Fault(
        "values", _beyond, "range|bound|limit|saturat|clip|exceed|outlier"
    ),
    "frame_deleted": Fault(
        "order", _reordered(lambda rows, copy: np.delete(rows, at()(copy))), IN_ORDER
    ),
    "frame_dropped_renumbered": Fault(
        "order", _lost, "frame|video|desync|length|count|span|row"
    ),
    "frame_duplicated": Fault(
        "order", _reordered(lambda rows, copy: np.insert(rows, at()(copy), at()(copy))), IN_ORDER
    ),
    "rows_swapped": Fault("order", _reordered(_two_swapped), IN_ORDER),
    "episodes_swapped_in_file": Fault(
        "order", _reordered(_episodes_swapped), f"{IN_ORDER}|episode|range|span|contigu"
    ),
    "frame_index_off_by_one": Fault(
        "order", _renumbered("frame_index", lambda v, span: v.__setitem__(span, v[span] + 1)),
        "index",
    ),
    "episode_index_gap": Fault("order", _called_57, "episode|gap|contigu|missing|order"),
    "index_not_contiguous": Fault(
        "order",
        _renumbered("index", lambda v, span: v.__setitem__(slice(span.start, None),
                                                           v[span.start :] + 100)),
        "index|contigu|order",
    ),
    "time_shifted_1_frame": Fault("time", _times(lambda t: t + 1 / 20), IN_TIME),
    "time_jitter_10pct": Fault("time", _times(_jittered), IN_TIME),
    "time_non_monotonic": Fault(
        "time", _times(lambda t: _at_row(t, t[ROW - 1] - 0.02)), IN_TIME
    ),
    "time_gap_half_second": Fault(
        "time", _times(lambda t: t + 0.5 * (np.arange(len(t)) >= ROW)), IN_TIME
    ),
    "time_drift": Fault("time", _times(lambda t: t * 1.0009), IN_TIME),
    "time_repeated": Fault("time", _times(lambda t: _at_row(t, t[ROW - 1])), IN_TIME),
    "fps_19_98_in_info": Fault("time", _fps(19.98), IN_TIME),
    "fps_30_in_info": Fault("time", _fps(30), IN_TIME),
    "time_epoch": Fault("time", _epoch, IN_TIME),
}  # fmt: skip
