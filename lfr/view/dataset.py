"""One episode of a LeRobot v3.0 dataset folder, read without importing LeRobot (4 to 17 s)."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from lfr.data.episode import ACTION, IMAGES, SUCCESS, Episode
from lfr.data.features import names_of, settings_of
from lfr.data.pictures import frames
from lfr.data.tables import DatasetFiles, Row
from lfr.embodiments import is_known
from lfr.errors import DataError
from lfr.tasks import TASKS
from lfr.view.depth import DEEP, is_picture, scaled, tensor
from lfr.view.episode import UNSAID
from lfr.view.series import entity_part

if TYPE_CHECKING:
    from PIL.Image import Image

NOT_NUMBERS = ("video", "image", "string", "language")  # dtypes in info.json


def is_dataset(path: Path) -> bool:
    """Whether a folder is a LeRobot dataset."""
    return (path / "meta" / "info.json").is_file()


def read_episode(path: Path, index: int) -> Episode:
    """Episode `index` of the dataset at `path`, its pictures as JPEG.

    Robot and task are those of the dataset's columns `robot` and `task_name`, or of a folder named
    `<robot>-<task>` by what is known here; else the robot is info.json's `robot_type`, and the task
    has no name: "". There are no simulator states in a dataset: (0, 0).

    Raises:
        DataError: no such episode, no actions, or a file that is missing or cut off.
    """
    files = DatasetFiles.open(path)
    info, row = files.info, files.episode(index)
    if ACTION not in info["features"]:
        raise DataError("a dataset without actions", file=path, column=ACTION,
                        found=", ".join(info["features"]))  # fmt: skip
    table = files.rows_of(row)
    features = {
        name: _array(table[name])
        for name, feature in info["features"].items()
        if name in table.column_names
        and feature["dtype"] not in NOT_NUMBERS
        and not is_picture(feature["shape"])
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
        images=_images(files, row, table),
        metadata={
            "instruction": ", ".join(row.get("tasks") or ()),
            "features": {
                name: {
                    "dtype": f["dtype"],
                    "names": _labels(name, f, features[name]) if name in features else (),
                    "about": "",
                }
                for name, f in info["features"].items()
            },
            "fps": files.fps,
            "file": files.source.name,
            "episode": index,
            "log_file": row.get("log_file"),
            "log_sha256": row.get("log_sha256"),
            UNSAID: unsaid,
        },
    )


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


def _labels(key: str, feature: Row, values: np.ndarray) -> tuple[str, ...]:
    """What info.json calls each dimension of a feature, or else its number: `state.0`."""
    names, size = names_of(feature), int(np.prod(values.shape[1:]))
    if len(names) == size:
        return tuple(names)
    last = key.rpartition(".")[2]
    return (last,) if size == 1 else tuple(f"{last}.{number}" for number in range(size))


def _images(files: DatasetFiles, row: Row, table: Any) -> dict[str, list[bytes]]:
    """The frames of each camera, from its video or out of the rows, as JPEG files."""
    found = {}
    for name, feature in files.features.items():
        camera = entity_part(name.removeprefix(IMAGES).removeprefix("observation."))
        if feature["dtype"] == "video":
            found[camera] = _frames(files, row, name)
        elif name in table.column_names and feature["dtype"] == "image":
            stills = [_still(files.path, name, value) for value in table[name].to_pylist()]
            if stills and stills[0].mode in DEEP:
                stills = scaled([np.asarray(still) for still in stills])
            found[camera] = [_jpeg(still) for still in stills]
        elif name in table.column_names and is_picture(feature["shape"]):
            try:
                frames = tensor(table[name], feature["shape"])
            except (ValueError, pa.ArrowException) as error:
                raise DataError("no pictures", file=files.path, column=name, found=error) from error
            found[camera] = [_jpeg(picture) for picture in scaled(list(frames))]
    return found


def _still(path: Path, name: str, value: Row) -> Image:
    """One picture that a dataset keeps in its rows, or beside them under the name that they say."""
    from PIL import Image

    try:
        content = value["bytes"] or (path / value["path"]).read_bytes()
        picture = Image.open(io.BytesIO(content))
        picture.load()
    except (OSError, TypeError) as error:
        raise DataError("no picture", file=path, column=name, found=error) from error
    return picture


def _jpeg(picture: Image) -> bytes:
    buffer = io.BytesIO()
    picture.convert("RGB").save(buffer, "JPEG", quality=90)
    return buffer.getvalue()


def _frames(files: DatasetFiles, row: Row, name: str) -> list[bytes]:
    """The frames of one camera as JPEG files, decoded from the dataset's video."""
    count = row["length"]
    start = files.number(row, f"videos/{name}/from_timestamp")
    first = round(start * files.fps)
    file = files.file_of(row, f"videos/{name}")
    decoded = frames(file, range(first, first + count), name)
    if settings_of(files.features[name]).get("is_depth_map") is True:
        pictures = scaled([frame.to_ndarray(format="gray16le") for frame in decoded])
        return [_jpeg(picture) for picture in pictures]
    return [_jpeg(frame.to_image()) for frame in decoded]
