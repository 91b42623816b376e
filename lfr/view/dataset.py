"""One episode of a LeRobot v3.0 dataset folder, read without importing LeRobot (4 to 17 s)."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lfr.artifacts import read_json
from lfr.data.episode import ACTION, IMAGES, SUCCESS, Episode
from lfr.embodiments import is_known
from lfr.errors import DataError
from lfr.tasks import TASKS
from lfr.view.episode import UNSAID
from lfr.view.series import entity_part

if TYPE_CHECKING:
    from PIL.Image import Image

NOT_NUMBERS = ("video", "image", "string", "language")  # dtypes in info.json

Row = dict[str, Any]


def is_dataset(path: Path) -> bool:
    """Whether a folder is a LeRobot dataset."""
    return (path / "meta" / "info.json").is_file()


def episode_rows(path: Path, index: int | None = None) -> list[Row]:
    """What the dataset says of each of its episodes, in order: length, seed, success, files.

    Args:
        path: the dataset.
        index: of the only episode that is wanted; None wants all.

    Raises:
        DataError: the dataset has no readable table of episodes.
    """
    import pyarrow.parquet as pq

    files = sorted((path / "meta" / "episodes").rglob("*.parquet"))
    if not files:
        raise DataError("no table of episodes", file=path, expected="meta/episodes/*/*.parquet")
    rows: list[Row] = []
    wanted = None if index is None else [("episode_index", "==", index)]
    for file in files:
        schema = _parquet(partial(pq.read_schema, file), file)
        columns = [name for name in schema.names if not name.startswith("stats/")]  # hundreds
        table = _parquet(partial(pq.read_table, file, columns=columns, filters=wanted), file)
        rows += table.to_pylist()
    return sorted(rows, key=lambda row: row["episode_index"])


def read_episode(path: Path, index: int) -> Episode:
    """Episode `index` of the dataset at `path`, its pictures as JPEG.

    Robot and task are those of the dataset's columns `robot` and `task_name`, or of a folder named
    `<robot>-<task>` by what is known here; else the robot is info.json's `robot_type`, and the task
    has no name: "". There are no simulator states in a dataset: (0, 0).

    Raises:
        DataError: no such episode, no actions, or a file that is missing or cut off.
    """
    import pyarrow.parquet as pq

    rows = episode_rows(path, index)
    if not rows:
        count = len(episode_rows(path))
        raise DataError("no such episode", file=path, episode=index, expected=f"0 to {count - 1}")
    row = rows[0]
    info = read_json(path / "meta" / "info.json")
    if ACTION not in info["features"]:
        raise DataError("a dataset without actions", file=path, column=ACTION,
                        found=", ".join(info["features"]))  # fmt: skip
    file = path / info["data_path"].format(
        chunk_index=row["data/chunk_index"], file_index=row["data/file_index"]
    )
    table = _parquet(partial(pq.read_table, file, filters=[("episode_index", "==", index)]), file)
    features = {
        name: _array(table[name])
        for name, feature in info["features"].items()
        if name in table.column_names and feature["dtype"] not in NOT_NUMBERS
    }
    folder, _, of = path.resolve().name.rpartition("-")
    success, seed = (
        value if isinstance(value := row.get(name), int) else None for name in ("success", "seed")
    )
    if success is None and SUCCESS in features:
        success = bool(np.any(features[SUCCESS]))
    unsaid = [name for name, value in (("seed", seed), ("success", success)) if value is None]
    robot = folder if is_known(folder) else info.get("robot_type")
    return Episode(
        robot=str(row.get("robot") or robot or ""),
        task=str(row.get("task_name") or (of if of in TASKS else "")),
        seed=int(seed or 0),
        success=bool(success),
        features=features,
        simulator_state=np.zeros((0, 0)),
        images=_images(path, info, row, table),
        metadata={
            "instruction": ", ".join(row.get("tasks") or ()),
            "features": {
                name: {
                    "dtype": f["dtype"],
                    "names": dimension_names(name, f, features[name]) if name in features else (),
                    "about": "",
                }
                for name, f in info["features"].items()
            },
            "fps": info["fps"],
            "file": str(path),
            "episode": index,
            "log_file": row.get("log_file"),
            "log_sha256": row.get("log_sha256"),
            UNSAID: unsaid,
        },
    )


def dimension_names(key: str, feature: Row, values: np.ndarray) -> tuple[str, ...]:
    """What info.json calls each dimension of a feature, or else its number: `state.0`.

    Names may be a list, a mapping from kinds to lists (`{"motors": [...]}`), of which there may be
    several, or one from names to numbers; some datasets have another number of them, or none.
    """
    size = int(np.prod(values.shape[1:]))
    names = feature.get("names")
    if isinstance(names, dict):
        lists = all(isinstance(part, list) for part in names.values())
        several = lists and len(names) > 1
        names = (
            [f"{kind}.{name}" if several else name for kind in names for name in names[kind]]
            if lists
            else list(names)
        )
    if isinstance(names, list) and len(names) == size:
        return tuple(str(name) for name in names)
    last = key.rpartition(".")[2]
    return (last,) if size == 1 else tuple(f"{last}.{number}" for number in range(size))


def find_log(path: Path, episode: Episode) -> Path | None:
    """The MCAP log that a dataset's episode was packed from, if it is there and unchanged.

    It is looked for as the dataset names it, and in `data/logs/<dataset>/` beside `data/lerobot/`.
    """
    from lfr.artifacts import file_hash

    name = episode.metadata.get("log_file")
    if not name:
        return None
    folder = path.resolve()
    places = [
        Path(name),
        folder / name,
        folder.parent.parent / "logs" / folder.name / Path(name).name,
    ]
    expected = episode.metadata.get("log_sha256")
    for place in places:
        if place.is_file() and expected in (None, file_hash(place)):
            return place
    return None


def _array(column: Any) -> np.ndarray:
    """A column of lists as (T, D), one of scalars, or of lists of one, as (T,)."""
    values = np.array(column.to_pylist())
    return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values


def _images(path: Path, info: Row, row: Row, table: Any) -> dict[str, list[bytes]]:
    """The frames of each camera, from its video or out of the rows, as JPEG files."""
    found = {}
    for name, feature in info["features"].items():
        camera = entity_part(name.removeprefix(IMAGES).removeprefix("observation."))
        if feature["dtype"] == "video":
            found[camera] = _frames(path, info, row, name)
        elif feature["dtype"] == "image" and name in table.column_names:
            found[camera] = [_still(path, name, value) for value in table[name].to_pylist()]
    return found


def _still(path: Path, name: str, value: Row) -> bytes:
    """One picture that a dataset keeps in its rows, or beside them under the name that they say."""
    from PIL import Image

    try:
        content = value["bytes"] or (path / value["path"]).read_bytes()
        return _jpeg(Image.open(io.BytesIO(content)))
    except (OSError, TypeError) as error:
        raise DataError("no picture", file=path, column=name, found=error) from error


def _jpeg(picture: Image) -> bytes:
    buffer = io.BytesIO()
    picture.convert("RGB").save(buffer, "JPEG", quality=90)
    return buffer.getvalue()


def _frames(path: Path, info: Row, row: Row, name: str) -> list[bytes]:
    """The frames of one camera as JPEG files, decoded from the dataset's video."""
    import av

    file = path / info["video_path"].format(
        video_key=name,
        chunk_index=row[f"videos/{name}/chunk_index"],
        file_index=row[f"videos/{name}/file_index"],
    )
    start = float(row[f"videos/{name}/from_timestamp"])
    frames: list[bytes] = []
    if not file.is_file():
        raise DataError("the video is missing", file=file, column=name)
    with av.open(str(file)) as video:
        stream = video.streams.video[0]
        base = float(stream.time_base or 1)
        video.seek(int(start / base), stream=stream)  # to the key frame before
        for frame in video.decode(stream):
            if len(frames) == row["length"]:
                break
            if (frame.pts or 0) * base >= start - 0.5 / info["fps"]:
                frames.append(_jpeg(frame.to_image()))
    if len(frames) != row["length"]:
        raise DataError(
            "the video is cut off",
            file=file,
            column=name,
            found=len(frames),
            expected=row["length"],
        )
    return frames


def _parquet(read: Callable[[], Any], file: Path) -> Any:
    import pyarrow as pa

    try:
        return read()
    except (pa.ArrowInvalid, OSError) as error:
        raise DataError("missing or cut-off Parquet", file=file, found=error) from error
