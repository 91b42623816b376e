"""What info.json promises of the features, against the types and shapes of the files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pyarrow as pa

from lfr.curation.contents import INFO, NOT_NUMBERS, Contents
from lfr.curation.finding import Finding
from lfr.data.episode import ACTION, STATE
from lfr.data.features import names_of, shape_of

# LeRobot's own columns and their types
DEFAULT_DTYPES = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
ARROW = {"float": "float32", "double": "float64", "halffloat": "float16"}  # arrow's names for them


def check_schema(contents: Contents) -> Iterator[Finding]:
    """Every feature is described, and every data file has it so."""
    _ = contents.fps  # a finding of its own where there is none
    for key, dtype in DEFAULT_DTYPES.items():
        if key not in contents.features:
            yield Finding("schema", "a column of LeRobot's is missing", file=INFO, column=key)
        elif contents.features[key].get("dtype") != dtype:
            found = contents.features[key].get("dtype")
            yield Finding("schema", "another dtype than LeRobot's", "error", INFO, None, key, None,
                          found, dtype)  # fmt: skip
    if "robot_type" not in contents.info:
        yield Finding("info", "no robot_type", "warning", INFO, column="robot_type")
    for key, feature in contents.features.items():
        yield from _described(key, feature)
    yield from _named(contents)
    yield from _episode_files(contents)
    for file, schema in zip(contents.data_files, contents.schemas, strict=True):
        for finding in _file(contents, relative := contents.relative(file), schema):
            yield replace(finding, episodes=contents.episodes_in(relative))


def _episode_files(contents: Contents) -> Iterator[Finding]:
    """LeRobot opens meta/episodes as one table, and fails where its files have other columns."""
    columns = {file: contents.opened(file).schema_arrow.names for file in contents.episode_files}
    if not columns:
        return
    every = dict.fromkeys(name for names in columns.values() for name in names)
    for file, names in columns.items():
        if lacking := [name for name in every if name not in names]:
            yield Finding("schema", "columns that other files of meta/episodes have are missing",
                          file=contents.relative(file), column=", ".join(lacking),
                          places=len(lacking))  # fmt: skip


def _described(key: str, feature: dict[str, Any]) -> Iterator[Finding]:
    shape, names = feature.get("shape"), names_of(feature)
    if feature.get("dtype") is None:
        yield Finding("schema", "a feature without dtype", file=INFO, column=key)
    if not (isinstance(shape, list) and all(isinstance(s, int) and s > 0 for s in shape)):
        yield Finding("schema", "no shape", file=INFO, column=key, found=shape,
                      expected="positive numbers")  # fmt: skip
    elif len(shape) == 1 and names and len(names) != shape[0]:
        one = len(names) == 1  # of the whole vector, as openpi's recorders write it
        yield Finding("schema", "another number of names than dimensions",
                      "warning" if one else "error", INFO, column=key, found=len(names),
                      expected=shape[0])  # fmt: skip


def _named(contents: Contents) -> Iterator[Finding]:
    """Actions without names beside states with names, which no writer of LeRobot's leaves.

    The other way round is clean: its recorder for reinforcement learning names actions alone. And
    where neither has names, nothing says that either should.
    """
    if not {ACTION, STATE} <= set(contents.numeric()):
        return
    action, state = (contents.features[key] for key in (ACTION, STATE))
    is_named = len(names := names_of(state)) > 1 and [len(names)] == shape_of(state)
    if is_named and shape_of(action) != [1] and not names_of(action):
        message = f"no names of its dimensions, and {STATE} has some"
        yield Finding("schema", message, "warning", INFO, None, ACTION)


def _file(contents: Contents, name: str, schema: pa.Schema) -> Iterator[Finding]:
    columns = {k: f for k, f in contents.features.items() if f.get("dtype") != "video"}
    for key in schema.names:
        if key not in columns:
            yield Finding("schema", "a column that info.json does not know", file=name, column=key,
                          found=str(schema.field(key).type), expected="no such column")  # fmt: skip
    for key, feature in columns.items():
        if key not in schema.names:
            yield Finding("schema", "a column is missing", file=name, column=key)
            continue
        dtype, shape = feature.get("dtype"), feature.get("shape")
        if dtype in NOT_NUMBERS or not isinstance(shape, list):
            continue
        found, sizes = element_type(schema.field(key).type)
        if found != dtype:
            yield Finding("dtype", "another type than info.json says", file=name, column=key,
                          found=found, expected=dtype)  # fmt: skip
        expected = [] if shape == [1] else shape
        # lists of any length are looked at row by row, where the values are
        if sizes is not None and len(shape) == 1 and sizes not in (expected, shape):
            yield Finding("shape", "another shape than info.json says", file=name, column=key,
                          found=tuple(sizes), expected=tuple(shape))  # fmt: skip


def element_type(type: pa.DataType) -> tuple[str, list[int] | None]:
    """Element type as info.json calls it, and the sizes of fixed lists around it.

    The sizes are None where they are not fixed.
    """
    sizes: list[int] | None = []
    if isinstance(type, pa.ExtensionType):  # `datasets` keeps arrays of more dimensions so
        type, sizes = type.storage_type, None
    while (
        pa.types.is_list(type) or pa.types.is_large_list(type) or pa.types.is_fixed_size_list(type)
    ):
        fixed = pa.types.is_fixed_size_list(type)
        sizes = [*sizes, type.list_size] if fixed and sizes is not None else None
        type = type.value_type
    return ARROW.get(str(type), str(type)), sizes
