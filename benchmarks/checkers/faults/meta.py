"""Faults of what is said of the rows: counts, the schema, statistics, tasks, outcomes."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.checkers.dataset_copy import DatasetCopy
from benchmarks.checkers.faults.fault import ROW, Fault, K, Plant, at
from lfr.curation.contents import INFO, TASKS
from lfr.data.stats import QUANTILES

PLACES = "range|index|length|count|rows|from|span|sum"
FILE = "file|chunk|missing|not found|no such|exist"
SHAPE = "shape|dim|size|width|names|schema"
STAT = "stat|normali|std|variance|quantile|q01|q99|count|nan|image|pixel"
TASK = "task|instruction|language|word"
TYPE = "type|dtype|float|double|binary|object|schema|numeric|unsupported|column"


def of_episode(column: str, by: float) -> Plant:
    """Another value in one episode's row of meta/episodes."""

    def plant(copy: DatasetCopy) -> None:
        values = copy.of_episodes(column)
        values[K] += type(values[K])(by)
        copy.put_of_episodes(column, values)

    return plant


def info(change: Callable[[dict[str, Any]], object]) -> Plant:
    return lambda copy: change(copy.info)


def feature(key: str, **said: Any) -> Plant:
    """Something else said of a feature in info.json; VIDEO is the camera's."""
    return lambda copy: copy.info["features"][
        copy.camera if key == "VIDEO" else key
    ].update(said)  # fmt: skip


def _total(name: str, by: int) -> Plant:
    return info(lambda i: i.update({name: i[name] + by}))


def _doubled(copy: DatasetCopy) -> None:
    rows = copy.rows["action"]
    _retype(copy, rows.cast(pa.list_(pa.float64(), rows.type.list_size)))


def _pickled(copy: DatasetCopy) -> None:
    _retype(copy, pa.array(map(pickle.dumps, copy.rows["action"].to_pylist()), pa.binary()))


def _retype(copy: DatasetCopy, actions: pa.Array | pa.ChunkedArray) -> None:
    place = copy.rows.column_names.index("action")
    copy.rows = copy.rows.set_column(place, "action", actions)


def _dropped(copy: DatasetCopy) -> None:
    copy.rows = copy.rows.drop_columns(["observation.environment_state"])


def _added(copy: DatasetCopy) -> None:
    zeros = pa.array(np.zeros(copy.rows.num_rows, np.float32))
    copy.rows = copy.rows.append_column("observation.debug", zeros)


def _cut_info(copy: DatasetCopy) -> None:
    text = (copy.root / INFO).read_text("utf-8")
    copy.replace(INFO, lambda new: new.write_text(text[:700], "utf-8"))


def _stat(change: Callable[[dict[str, Any]], object]) -> Plant:
    return lambda copy: change(copy.stats)


def _of(key: str, name: str, value: float | Callable[[float], float], at: int = 0) -> Plant:
    """Another number in one statistic of meta/stats.json."""

    def plant(copy: DatasetCopy) -> None:
        numbers = copy.stats[key][name]
        numbers[at] = value(numbers[at]) if callable(value) else value

    return plant


def _both(*plants: Plant) -> Plant:
    return lambda copy: [plant(copy) for plant in plants]


def _stale(stats: dict[str, Any]) -> None:
    of = stats["action"]
    of["mean"] = [m + 0.01 * s for m, s in zip(of["mean"], of["std"], strict=True)]


def _in_bytes(copy: DatasetCopy) -> None:
    of = copy.stats[copy.camera]
    of |= {name: (255 * np.array(v)).tolist() for name, v in of.items() if name != "count"}


def _episode_mean(copy: DatasetCopy) -> None:
    means = copy.of_episodes("stats/action/mean")
    means[K] = [mean + 0.5 for mean in means[K]]
    copy.put_of_episodes("stats/action/mean", means)


def words(*texts: str, first: int = 0, everywhere: bool = False) -> Plant:
    """Another table of tasks; "" stands for the words that there are, of which one can be more."""

    def plant(copy: DatasetCopy) -> None:
        there = pq.read_table(copy.root / TASKS)
        known = there["task"][0].as_py()
        new = pa.table({
            "task_index": pa.array(range(first, first + len(texts)), pa.int64()),
            "task": [known if text == "SAME" else text for text in texts],
        }).replace_schema_metadata(there.schema.metadata)  # fmt: skip
        copy.replace(TASKS, lambda file: pq.write_table(new, file))
        if everywhere:
            copy.put_of_episodes("tasks", [list(texts)] * copy.episodes.num_rows)

    return plant


def _other_task(copy: DatasetCopy) -> None:
    tasks = copy.of_episodes("tasks")
    tasks[K] = ["fold the towel"]
    copy.put_of_episodes("tasks", tasks)


def _done(row: int, done: bool) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        copy.change("next.done", copy.span(K).start + row % _length(copy), done)
        copy.restat("next.done")

    return plant


def _length(copy: DatasetCopy) -> int:
    return copy.of_episodes("length")[K]


def _failed(copy: DatasetCopy) -> None:
    outcomes = copy.of_episodes("success")
    outcomes[K] = False
    copy.put_of_episodes("success", outcomes)


def _failed_in_rows(copy: DatasetCopy) -> None:
    copy.change("next.success", copy.span(K), False)
    copy.restat("next.success")


FAULTS = {
    "dataset_from_index_wrong": Fault("counts", of_episode("dataset_from_index", 5), PLACES),
    "dataset_to_index_wrong": Fault("counts", of_episode("dataset_to_index", 5), PLACES),
    "length_wrong": Fault("counts", of_episode("length", 3), "length|count|rows|frames"),
    "data_file_index_wrong": Fault("counts", of_episode("data/file_index", 1), FILE),
    "data_chunk_index_wrong": Fault("counts", of_episode("data/chunk_index", 1), FILE),
    "total_frames_wrong": Fault("counts", _total("total_frames", 11), "frames|count"),
    "total_episodes_wrong": Fault("counts", _total("total_episodes", 2), "episodes|count"),
    "total_tasks_wrong": Fault("counts", _total("total_tasks", 8), "task"),
    "splits_wrong": Fault("counts", info(lambda i: i.update(splits={"train": "0:80"})), "split"),
    "codebase_version_unknown": Fault(
        "schema", info(lambda i: i.update(codebase_version="v9.9")), "version|v9.9"
    ),
    "fps_missing": Fault("schema", info(lambda i: i.pop("fps")), "fps|rate|frames per second"),
    "fps_string": Fault("schema", info(lambda i: i.update(fps="20")), "fps|rate|frames per second"),
    "robot_type_missing": Fault("schema", info(lambda i: i.pop("robot_type")), "robot"),
    "feature_shape_wrong": Fault("schema", feature("action", shape=[9], names=None), SHAPE),
    "feature_dtype_wrong": Fault("schema", feature("action", dtype="float64"), TYPE),
    "names_count_wrong": Fault("schema", feature("action", names=["dx", "dy", "dz"]), SHAPE),
    "names_missing": Fault("schema", feature("action", names=None), "names"),
    "column_missing": Fault("schema", _dropped, "missing|column|feature|schema"),
    "column_extra": Fault(
        "schema", _added, "extra|unknown|column|undeclared|feature|not know|schema|debug"
    ),
    "action_float64_in_rows": Fault("schema", _doubled, TYPE),
    "action_pickled_objects": Fault("schema", _pickled, TYPE),
    "info_cut_off": Fault("schema", _cut_info, "info|json|parse|cut|invalid|meta"),
    "info_absent": Fault(
        "schema", lambda copy: (copy.root / INFO).unlink(), "info|missing|not a|found|meta|exist"
    ),
    "stats_mean_wrong": Fault("statistics", _of("action", "mean", lambda m: m + 0.5), STAT),
    "stats_std_zero": Fault("statistics", _of("action", "std", 0.0), STAT),
    "stats_min_max_wrong": Fault(
        "statistics",
        _both(_of("observation.state", "min", 0.0, 2), _of("observation.state", "max", 100.0, 2)),
        STAT,
    ),
    "stats_quantile_wrong": Fault("statistics", _of("action", "q99", 5.0), STAT),
    "stats_count_wrong": Fault("statistics", _of("action", "count", 100), STAT),
    "stats_nan": Fault("statistics", _of("action", "mean", float("nan")), STAT),
    "stats_feature_missing": Fault("statistics", _stat(lambda s: s.pop("action")), STAT),
    "stats_quantiles_missing": Fault(
        "statistics", _stat(lambda s: [s["action"].pop(q) for q in QUANTILES]), STAT
    ),
    "stats_stale_1pct": Fault("statistics", _stat(_stale), STAT),
    "stats_absent": Fault(
        "statistics", lambda copy: (copy.root / "meta/stats.json").unlink(), STAT
    ),
    "stats_image_0_255": Fault("statistics", _in_bytes, STAT),
    "episode_stats_wrong": Fault("statistics", _episode_mean, STAT),
    "tasks_index_missing": Fault("tasks", words("SAME", first=1), TASK),
    "task_index_out_of_range": Fault(
        "tasks", lambda copy: copy.change("task_index", at(ROW)(copy), 5), TASK
    ),
    "tasks_same_words_twice": Fault(
        "tasks", _both(words("SAME", "SAME"), info(lambda i: i.update(total_tasks=2))), TASK
    ),
    "task_empty_words": Fault("tasks", words("", everywhere=True), TASK),
    "episode_lists_another_task": Fault("tasks", _other_task, TASK),
    "tasks_file_absent": Fault("tasks", lambda copy: (copy.root / TASKS).unlink(), TASK),
    "done_missing_at_end": Fault("outcome", _done(-1, False), "done|terminal|end"),
    "done_early": Fault("outcome", _done(ROW, True), "done|early|terminal"),
    "episode_without_success": Fault(
        "outcome", _both(_failed, _failed_in_rows), "success|fail|outcome"
    ),
    "success_disagrees": Fault("outcome", _failed, "success|fail|outcome|disagree"),
}  # fmt: skip
