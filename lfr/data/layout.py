"""LeRobot v3.0's layout: what its files are called, its own columns, and the types of rows.

LeRobot says all this itself, but not before it has imported torch, 750 MiB of memory in all, which
is then not there for reading and encoding. A test holds what is said here to what LeRobot says.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa

EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
CHUNK_SIZE = 1000  # files in a folder
DATA_MEGABYTES, VIDEO_MEGABYTES = 100, 200  # of a file, before compression and as it is

DEFAULT_FEATURES: dict[str, dict[str, Any]] = {
    key: {"dtype": dtype, "shape": (1,), "names": None}
    for key, dtype in {
        "timestamp": "float32",
        "frame_index": "int64",
        "episode_index": "int64",
        "index": "int64",
        "task_index": "int64",
    }.items()
}


def video_path(key: str) -> str:
    """The format string of a feature's videos, with chunk_index and file_index."""
    return VIDEO_PATH.replace("{video_key}", key)


def row_schema(features: Mapping[str, Mapping[str, Any]]) -> pa.Schema:
    """The columns of a dataset's rows, with the types as the `datasets` library keeps them.

    Args:
        features: entries of info.json that are numbers, of shape (D,), a scalar (1,).
    """
    import pyarrow as pa

    fields, kept = [], {}
    for key, feature in features.items():
        (size,) = feature["shape"]
        type, about = pa.type_for_alias(feature["dtype"]), _value(feature["dtype"])
        if size != 1:
            type, about = pa.list_(type, size), {"feature": about, "length": size, "_type": "List"}
        fields.append(pa.field(key, type))
        kept[key] = about
    return pa.schema(fields, {"huggingface": json.dumps({"info": {"features": kept}})})


def _value(dtype: str) -> dict[str, Any]:
    return {"dtype": dtype, "_type": "Value"}
