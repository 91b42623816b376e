"""A sound dataset broken in one way each, and the finding that must say so.

`BROKEN`: name -> what breaks it, the finding's check and severity, and what its line must show.
"""

from __future__ import annotations

import json
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

Break = Callable[[Path], object]

DATA = "data/chunk-000/file-000.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
CAMERA = "observation.images.agentview"
VIDEO = f"videos/{CAMERA}/chunk-000/file-000.mp4"
TASKS = "meta/tasks.parquet"


def json_of(file: str, edit: Callable[[dict[str, Any]], object]) -> Break:
    def broken(dataset: Path) -> None:
        content = json.loads((dataset / file).read_text())
        edit(content)
        (dataset / file).write_text(json.dumps(content))

    return broken


def table(file: str, edit: Callable[[pa.Table], pa.Table]) -> Break:
    return lambda dataset: pq.write_table(edit(pq.read_table(dataset / file)), dataset / file)


def column(file: str, name: str, edit: Callable[[list[Any]], object]) -> Break:
    """Change the values of a column, its type kept."""

    def edited(before: pa.Table) -> pa.Table:
        values = before[name].to_pylist()
        edit(values)
        at = before.column_names.index(name)
        field = before.schema.field(at)
        return before.set_column(at, field, pa.array(values, field.type))

    return table(file, edited)


def put(file: str, name: str, row: int, value: object) -> Break:
    return column(file, name, lambda values: values.__setitem__(row, value))


def dimension(name: str, row: int, i: int, value: float) -> Break:
    return column(DATA, name, lambda values: values[row].__setitem__(i, value))


def retyped(name: str, type: pa.DataType, edit: Callable[[list[Any]], list[Any]]) -> Break:
    def edited(before: pa.Table) -> pa.Table:
        at = before.column_names.index(name)
        return before.set_column(at, name, pa.array(edit(before[name].to_pylist()), type))

    return table(DATA, edited)


def cut(file: str, kept: float) -> Break:
    def broken(dataset: Path) -> None:
        content = (dataset / file).read_bytes()
        (dataset / file).write_bytes(content[: int(kept * len(content))])

    return broken


def removed(file: str) -> Break:
    return lambda dataset: (dataset / file).unlink()


def copied(file: str, to: str) -> Break:
    def broken(dataset: Path) -> None:
        (dataset / to).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(dataset / file, dataset / to)

    return broken


def without_index(dataset: Path) -> None:
    """As a recorder that is killed leaves it: the samples, and no table of them."""
    content = (dataset / VIDEO).read_bytes()
    (dataset / VIDEO).write_bytes(content.replace(b"moov", b"free", 1))


def slower(dataset: Path) -> None:
    """One frame of the video lasts two: its first run of durations is taken apart."""
    content = bytearray((dataset / VIDEO).read_bytes())
    at = content.index(b"stts")
    runs, frames, ticks = struct.unpack_from(">III", content, at + 8)
    assert runs == 1
    struct.pack_into(">II", content, at + 12, frames, 2 * ticks)
    (dataset / VIDEO).write_bytes(content)


def shorter(dataset: Path) -> None:
    """A video of the first episode alone in the place of the whole one."""
    from lfr.curation.clips import Clip, write_clip

    write_clip(Clip(dataset / VIDEO, 0, 12), dataset / "short.mp4", 20, None)
    shutil.move(dataset / "short.mp4", dataset / VIDEO)


def longer(dataset: Path) -> None:
    """The last episode is gone from rows and episodes, its frames are still in the video."""
    table(DATA, lambda t: t.slice(0, 43))(dataset)
    table(EPISODES, lambda t: t.slice(0, 4))(dataset)
    json_of("meta/info.json", lambda info: info.update(
        total_frames=43, total_episodes=4, splits={"train": "0:4"}))(dataset)  # fmt: skip


def in_two_files(dataset: Path) -> None:
    """The second half of the rows moved on, the episodes not told."""
    rows = pq.read_table(dataset / DATA)
    pq.write_table(rows.slice(0, 21), dataset / DATA)
    pq.write_table(rows.slice(21), dataset / DATA.replace("file-000", "file-001"))


def all_rows(name: str, edit: Callable[[np.ndarray], object]) -> Break:
    """Change a vector column in place, as one array."""

    def change(values: list[Any]) -> None:
        array = np.array(values)
        edit(array)
        values[:] = array.tolist()

    return column(DATA, name, change)


def assign(where: Any, value: Any) -> Callable[[np.ndarray], object]:
    return lambda array: array.__setitem__(where, value)


def frozen(dataset: Path) -> None:
    """Rows 12 to 20, episode 1, all as its first."""
    for name in ("state", "environment_state", "joint_position"):
        all_rows(f"observation.{name}", lambda a: a.__setitem__(slice(12, 21), a[12]))(dataset)


def info(**values: Any) -> Break:
    return json_of("meta/info.json", lambda content: content.update(values))


def feature(key: str, **values: Any) -> Break:
    return json_of("meta/info.json", lambda content: content["features"][key].update(values))


def stats(edit: Callable[[dict[str, Any]], object]) -> Break:
    return json_of("meta/stats.json", edit)


def failed(dataset: Path) -> None:
    column(DATA, "next.success", lambda v: v.__setitem__(slice(None), [False] * len(v)))(dataset)
    column(EPISODES, "success", lambda v: v.__setitem__(slice(None), [False] * len(v)))(dataset)


def log_changed(dataset: Path) -> None:
    log = dataset.parent.parent / "logs/panda-lift/episode-000003.mcap"
    log.write_bytes(log.read_bytes() + b" ")


def log_removed(dataset: Path) -> None:
    (dataset.parent.parent / "logs/panda-lift/episode-000003.mcap").unlink()


def same_log(dataset: Path) -> None:
    column(EPISODES, "log_sha256", lambda v: v.__setitem__(4, v[1]))(dataset)


TO = f"videos/{CAMERA}/to_timestamp"
FROM = f"videos/{CAMERA}/from_timestamp"

BROKEN: dict[str, tuple[Break, str, str, str]] = {
    # files
    "rows cut off": (cut(DATA, 0.6), "damaged-file", "error", f"Parquet: {DATA}"),
    "rows empty": (cut(DATA, 0), "damaged-file", "error", f"Parquet: {DATA}"),
    "episodes cut off": (cut(EPISODES, 0.99), "damaged-file", "error", f"Parquet: {EPISODES}"),
    "tasks cut off": (cut(TASKS, 0.5), "damaged-file", "error", f"Parquet: {TASKS}"),
    "info cut off": (cut("meta/info.json", 0.5), "info", "error", "meta/info.json"),
    "stats cut off": (cut("meta/stats.json", 0.5), "statistics", "error", "cut off"),
    "video cut off": (cut(VIDEO, 0.9), "damaged-file", "error", f"{VIDEO}, episode 0"),
    "video not finalized": (without_index, "damaged-file", "error", "unfinalized"),
    "rows missing": (removed(DATA), "missing-file", "error", DATA),
    "video missing": (removed(VIDEO), "missing-file", "error", f"{VIDEO}.*and 4 more"),
    "tasks missing": (removed(TASKS), "missing-file", "error", TASKS),
    "stats missing": (removed("meta/stats.json"), "missing-file", "warning", "meta/stats.json"),
    "a video too many": (copied(VIDEO, VIDEO.replace("file-000", "file-001")), "left-over",
                         "warning", "file-001.mp4"),
    "pictures left": (copied(VIDEO, "images/a/episode-000000/frame-000000.png"), "left-over",
                      "warning", "interrupted"),
    "an unfinished file": (copied(DATA, "data/chunk-000/x.partial"), "left-over", "warning",
                           "x.partial"),
    "chunks too full": (lambda d: (in_two_files(d), put(EPISODES, "data/file_index", 4, 1)(d),
                                   info(chunks_size=1)(d)), "counts", "warning", "chunks_size"),
    # schema
    "no features": (info(features=None), "info", "error", "no features"),
    "no fps": (info(fps=0), "info", "error", "column fps, found 0"),
    "a path outside": (info(data_path="../x/{chunk_index}-{file_index}.parquet"), "info", "error",
                       "leads out.*column data_path, found ../x/0-0.parquet"),
    "a path that fills the memory": (info(data_path="x/{chunk_index:03000000000d}{file_index}"),
                                     "info", "error", "no such path.*03000000000d"),
    "a path with a width of its own": (info(data_path="x/{chunk_index:{file_index}}"), "info",
                                       "error", "no such path.*file_index"),
    "no path": (info(data_path=None), "info", "error", "column data_path"),
    "a column missing": (table(DATA, lambda t: t.drop_columns(["action"])), "schema", "error",
                         f"{DATA}, column action"),
    "a column too many": (table(DATA, lambda t: t.append_column("extra", t["index"])), "schema",
                          "error", "column extra"),
    "LeRobot's column unknown": (json_of("meta/info.json", lambda i: i["features"].pop("index")),
                                 "schema", "error", "meta/info.json, column index"),
    "too few names": (feature("action", names=["a", "b"]), "schema", "error",
                      "column action, found 2, expected 7"),
    "actions without names": (feature("action", names=None), "schema", "warning",
                              "no names.*observation.state has some: meta/info.json, column act"),
    "no shape": (feature("action", shape=None), "schema", "error", "no shape.*column action"),
    "another dtype": (retyped("action", pa.list_(pa.float64(), 7), lambda v: v), "dtype", "error",
                      "column action, found float64, expected float32"),
    "another shape": (retyped("action", pa.list_(pa.float32(), 6), lambda v: [x[:6] for x in v]),
                      "shape", "error", r"column action, found \(6,\), expected \(7,\)"),
    "ragged": (retyped("action", pa.list_(pa.float32()),
                       lambda v: [x[: 6 + i % 2] for i, x in enumerate(v)]),
               "shape", "error", r"column action.*lengths \[6, 7\]"),
    "video of another size": (feature(CAMERA, shape=[32, 64, 3]), "shape", "error",
                              r"found \(64, 64\), expected \(32, 64\)"),
    "another rate than its info": (feature(CAMERA, info={"video.fps": 30}), "fps", "error",
                                   "found 30, expected 20"),
    "no robot": (json_of("meta/info.json", lambda i: i.pop("robot_type")), "info", "warning",
                 "no robot_type"),
    "a link out": (lambda d: (d / DATA).rename(d.parent / "elsewhere.parquet")
                   and (d / DATA).symlink_to((d.parent / "elsewhere.parquet").resolve()),
                   "link", "warning", f"{DATA}, found .*elsewhere.parquet"),
    "another codec": (feature(CAMERA, info={"video.codec": "h264"}), "format", "warning",
                      "video.codec, found av1, expected h264"),
    # counts
    "frames miscounted": (info(total_frames=50), "counts", "error",
                          "total_frames, found 50, expected 55"),
    "episodes miscounted": (info(total_episodes=6), "counts", "error",
                            "total_episodes, found 6, expected 5"),
    "tasks miscounted": (info(total_tasks=2), "counts", "error", "found 2, expected 1"),
    "a split beyond": (info(splits={"train": "0:9"}), "counts", "error", "splits.train, found 0:9"),
    "rows gone": (table(DATA, lambda t: t.slice(0, 50)), "counts", "error",
                  "episode 4, column length, found 7, expected 12"),
    "another length": (put(EPISODES, "length", 1, 10), "counts", "error",
                       "episode 1, column length, found 9, expected 10"),
    "an empty episode": (put(EPISODES, "length", 1, 0), "counts", "error", "empty.*episode 1"),
    "another's rows": (put(EPISODES, "dataset_from_index", 2, 20), "counts", "error",
                       "episode 2, column dataset_from_index, found 20, expected 21"),
    "rows of no episode": (put(DATA, "episode_index", 54, 7), "counts", "error",
                           "column episode_index, row 54, found 7"),
    "episodes in no order": (put(EPISODES, "episode_index", 2, 3), "episode-index", "error",
                             "found 3, expected 2"),
    "rows in another file": (in_two_files, "counts", "error",
                             "file-001.parquet, episode 2.*row 21, .*expected data/chunk-000/file"),
    # order and time
    "index": (put(DATA, "index", 20, 3), "index", "error",
              "episode 1.*row 20, found 3, expected 20"),
    "frame index": (put(DATA, "frame_index", 20, 3), "frame-index", "error",
                    "row 20, found 3, expected 8"),
    "an episode in pieces": (put(DATA, "episode_index", 30, 0), "episode-index", "error",
                             "row 30, found 0, expected above 2"),
    "a gap": (column(DATA, "timestamp", lambda v: v.__setitem__(slice(16, 21),
                                                               [t + 1 for t in v[16:21]])),
              "gap-in-time", "error", "episode 1, column timestamp, row 16, found 1.2.*ed 0.2"),
    "a jump back": (put(DATA, "timestamp", 16, 0.05), "jump-in-time", "error",
                    "row 16, found 0.05"),
    "no time": (put(DATA, "timestamp", 16, float("nan")), "jump-in-time", "error", "row 16"),
    "a late start": (column(DATA, "timestamp", lambda v: v.__setitem__(slice(12, 21),
                                                                      [t + 5 for t in v[12:21]])),
                     "time-start", "error", "row 12, found 5, expected 0"),
    "a drift": (column(DATA, "timestamp", lambda v: v.__setitem__(
                    slice(0, 55), [t * 1.0015 for t in v])),
                "gap-in-time", "error", "drifts"),
    "another fps": (info(fps=30), "fps", "error", "column fps, found 20, expected 30"),
    "a task without words": (put(DATA, "task_index", 5, 4), "tasks", "error", "row 5, found 4"),
    "empty words": (column(TASKS, "task", lambda v: v.__setitem__(0, " ")), "tasks", "warning",
                    "no words.*task 0"),
    "control characters": (column(TASKS, "task", lambda v: v.__setitem__(0, "a\x1b[2Jb")), "tasks",
                           "warning", "control characters"),
    "other tasks": (put(EPISODES, "tasks", 3, ["Dance."]), "tasks", "error",
                    r"episode 3, column tasks, found \['Dance.'\], expected \['Lift the cube.'\]"),
    # values
    "NaN": (dimension("observation.state", 14, 2, float("nan")), "not-finite", "error",
            "episode 1, column observation.state, row 14"),
    "infinite": (put(DATA, "next.reward", 3, float("inf")), "not-finite", "error", "next.reward"),
    "null": (put(DATA, "next.reward", 3, None), "shape", "error", "1 missing values"),
    "an action beyond": (dimension("action", 14, 1, 1.5), "range", "error",
                         "column action.dy, row 14, found 1.5, expected -1 to 1"),
    "a place beyond": (dimension("observation.environment_state", 3, 0, 100.0), "range", "error",
                       "cube_pos.x, row 3, found 100"),
    "a joint beyond": (dimension("observation.joint_position", 3, 5, 90.0), "range", "error",
                       "robot0_joint6, row 3, found 90"),
    "constant": (all_rows("action", assign((slice(None), 4), 0.5)), "constant", "warning",
                 "column action.dry, found 0.5"),
    "a spike": (all_rows("observation.joint_position", lambda a: (
                    a.__imul__(1e-4), a.__setitem__((7, 2), 3.0))), "spike", "warning",
                "robot0_joint3, row 7, found 3"),
    "frozen": (frozen, "frozen", "warning", "episode 1, row 12"),
    "done early": (put(DATA, "next.done", 4, True), "done", "error", "row 4"),
    "not done": (put(DATA, "next.done", 11, False), "done", "warning", "row 11"),
    "another outcome": (put(EPISODES, "success", 2, False), "success", "error",
                        "episode 2, column success, found False, expected True"),
    "no success": (failed, "success", "warning", "0 of 5"),
    # statistics
    "a mean": (stats(lambda s: s["action"]["mean"].__setitem__(3, 0.9)), "statistics", "error",
               "column action/mean, found 0.9"),
    "a deviation": (stats(lambda s: s["action"]["std"].__setitem__(3, 0.7)), "statistics", "error",
                    "action/std, found 0.7"),
    "a quantile": (stats(lambda s: s["action"]["q01"].__setitem__(0, 0.0)), "statistics", "error",
                   "action/q01, found 0"),
    "a count": (stats(lambda s: s["action"].update(count=[54])), "statistics", "error",
                "action/count, found 54, expected 55"),
    "NaN statistics": (stats(lambda s: s["action"]["max"].__setitem__(0, float("nan"))),
                       "statistics", "error", "action/max"),
    "statistics of another shape": (stats(lambda s: s["action"]["max"].pop()), "statistics",
                                    "error", "action/max.*expected 7 numbers"),
    "no statistics": (stats(lambda s: s.pop("action")), "statistics", "warning", "column action"),
    "a statistic missing": (stats(lambda s: s["action"].pop("q50")), "statistics", "warning",
                            "column action, .*expected q50"),
    "pixels": (stats(lambda s: s[CAMERA].update(mean=[[[0.99]], [[0.5]], [[0.5]]])), "statistics",
               "error", f"{CAMERA}/mean"),
    "pixels beyond": (stats(lambda s: s[CAMERA].update(max=[[[255]], [[255]], [[255]]])),
                      "statistics", "error", r"\[0, 1\]"),
    "pixels of which some are missing": (stats(lambda s: s[CAMERA].update(q01=[[[0.1]]])),
                                         "statistics", "error", f"not as many.*{CAMERA}"),
    "no table of statistics": (stats(lambda s: s.update(action=3)), "statistics", "warning",
                               "column action"),
    "an unfinished folder": (copied(DATA, "data/.partial-chunk/x"), "left-over", "warning",
                             "data/.partial-chunk"),
    "an episode's mean": (column(EPISODES, "stats/action/mean",
                                 lambda v: v[3].__setitem__(2, 0.9)),
                          "statistics", "error", "episode 3, column stats/action/mean"),
    "an episode's quantile": (column(EPISODES, "stats/action/q90",
                                     lambda v: v[3].__setitem__(2, -1.0)),
                              "statistics", "error", "episode 3, column stats/action/q90"),
    # videos
    "a shorter video": (shorter, "video-frames", "error",
                        "ends before.*episode 1.*found 12, expected 21.*3 more"),
    "a longer video": (longer, "video-frames", "warning", "found 55, expected 43"),
    "a slower video": (slower, "fps", "error", f"{VIDEO}.*found 0.1, expected 0.05"),
    "another end": (put(EPISODES, TO, 4, 2.8), "video-frames", "error",
                    "episode 4.*found 13, expected 12"),
    "another's frames": (lambda d: (put(EPISODES, FROM, 2, 1.0)(d), put(EPISODES, TO, 2, 1.75)(d)),
                         "video-frames", "error", "episode 2.*found 20, expected 21"),
    "between two frames": (lambda d: (put(EPISODES, FROM, 2, 1.06)(d),
                                      put(EPISODES, TO, 2, 1.81)(d)),
                           "video-frames", "error", "between.*episode 2.*found 1.06"),
    # where it comes from
    "a held-out seed": (put(EPISODES, "seed", 2, 2_000_000), "leaked-seed", "error",
                        "held-out.*episode 2, column seed, found 2000000"),
    "a learning seed": (put(EPISODES, "seed", 2, 1_000_007), "leaked-seed", "error", "learning"),
    "a seed of no range": (put(EPISODES, "seed", 2, -1), "leaked-seed", "error", "found -1"),
    "a seed twice": (put(EPISODES, "seed", 2, 1), "repeated-seed", "warning", "episode 2"),
    "another log": (log_changed, "log", "error", "episode-000003.mcap, episode 3"),
    "a log gone": (log_removed, "log", "warning", "episode 3.*found episode-000003.mcap"),
    "a log twice": (same_log, "log", "error", "same log.*episode 4.*than episode 1's"),
}  # fmt: skip
