"""Features as info.json describes them, told from the files: columns of rows, headers of videos."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from lfr.curation.checks.schema import element_type
from lfr.curation.contents import DEFAULT_FEATURES, Contents
from lfr.curation.finding import unreadable
from lfr.curation.mp4 import BrokenVideoError, read_header
from lfr.curation.repair.draft import Unmendable
from lfr.data.features import shape_of
from lfr.data.tables import files_below

Feature = dict[str, Any]

NUMBERS = ("bool", "float", "int", "uint")
PICTURE_AXES = ["height", "width", "channels"]


def features_of(contents: Contents) -> dict[str, Feature]:
    """Of the columns of the rows, then the cameras, then LeRobot's own columns.

    Raises:
        Unmendable: a column of a type that is none of LeRobot's, no whole video of a camera.
        Unreadable: rows that cannot be read.
    """
    columns = columns_of(contents)
    own = {key: columns.pop(key) for key in DEFAULT_FEATURES if key in columns}
    return {**columns, **dict(_cameras(contents.path)), **own}


def columns_of(contents: Contents, names: list[str] | None = None) -> dict[str, Feature]:
    """Of columns of the rows, by default all."""
    schema = contents.schemas[0]
    names = names or schema.names
    return {name: _column(contents, name, schema.field(name).type) for name in names}


def unnamed(features: dict[str, Feature]) -> list[str]:
    """Features of more than one dimension whose names are not known."""
    return [key for key, f in features.items() if not f.get("names") and shape_of(f) != [1]]


def _column(contents: Contents, name: str, type: pa.DataType) -> Feature:
    if pa.types.is_struct(type) and {"bytes", "path"} <= {f.name for f in type}:
        return {"dtype": "image", "shape": _picture_shape(contents, name), "names": PICTURE_AXES}
    dtype, sizes = element_type(type)
    if dtype == "large_string":
        dtype = "string"
    if not (dtype == "string" or dtype.startswith(NUMBERS)) or (dtype == "string" and sizes != []):
        raise Unmendable(f"info.json: the column {name} is of a type that no feature has: {type}")
    shape = _shape(contents, name) if sizes is None else sizes
    return {"dtype": dtype, "shape": shape or [1], "names": None}


def _shape(contents: Contents, name: str) -> list[int]:
    """Of lists whose type does not say how long they are: that of all rows."""
    column = contents.table([name])[name].combine_chunks()
    shape: list[int] = []
    while True:
        while isinstance(column, pa.ExtensionArray):
            column = column.storage
        if not pa.types.is_nested(column.type):
            return shape
        count, flat = len(column), column.flatten()
        size = len(flat) // max(count, 1)
        lengths = set(pc.call_function("list_value_length", [column]).to_pylist())
        if lengths != {size}:
            raise Unmendable(f"info.json: the lists of the column {name} are not of one length")
        shape.append(size)
        column = flat


def _picture_shape(contents: Contents, name: str) -> list[int]:
    from PIL import Image

    with unreadable("damaged-file", "a picture that cannot be read", OSError, TypeError, IndexError,
                    file="data", column=name):  # fmt: skip
        file = contents.opened(contents.data_files[0])
        group = file.read_row_group(0, columns=[name], use_threads=False)
        picture = Image.open(BytesIO(group[name][0].as_py()["bytes"]))
        return [picture.height, picture.width, len(picture.getbands())]


def _cameras(path: Path) -> Iterator[tuple[str, Feature]]:
    files: dict[str, list[Path]] = {}
    for file in files_below(path / "videos", ".mp4"):
        files.setdefault(file.relative_to(path / "videos").parts[0], []).append(file)
    for key, videos in files.items():
        yield key, _camera(key, videos)


def _camera(key: str, videos: list[Path]) -> Feature:
    from lerobot.datasets.video_utils import get_video_info

    whole = []
    for file in videos:
        try:
            header = read_header(file)
        except (BrokenVideoError, OSError):
            continue  # said where videos are checked
        whole.append((file, header))
    if len({(header.height, header.width) for _, header in whole}) != 1:
        raise Unmendable(f"info.json: no whole video of {key}, or several of different sizes")
    file, header = whole[0]
    info = get_video_info(file)
    shape = [header.height, header.width, info.get("video.channels", 3)]
    return {"dtype": "video", "shape": shape, "names": PICTURE_AXES, "info": info}
