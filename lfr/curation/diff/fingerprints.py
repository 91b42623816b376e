"""Hashes of rows, the same for the same values in whichever type, file and row group they lie."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

Hashes = NDArray[np.uint64]
EXACT = 2**53  # whole numbers below are the same as a float64


def numbers(array: pa.Array) -> NDArray | None:
    """(n, D) of numbers, or of lists of one length, however deep; a missing one is NaN.

    Returns:
        None where they are no numbers, or lists of several lengths.
    """
    count, values = len(array), array
    while _is_list(values.type):
        if values.null_count:
            return None
        if not pa.types.is_fixed_size_list(values.type):
            lengths: NDArray = np.diff(values.offsets.to_numpy())  # pyright: ignore[reportAttributeAccessIssue]
            if (lengths != lengths[:1]).any():
                return None
        values: Any = values.flatten()  # pyright: ignore[reportAttributeAccessIssue]
    if pa.types.is_boolean(values.type):
        values = values.cast(pa.uint8())
    if not is_numeric(values.type) or not count:
        return None
    return values.to_numpy(zero_copy_only=False).reshape(count, -1)


def is_numeric(type: pa.DataType) -> bool:
    """Whether a column's type is numbers, or lists of them."""
    while _is_list(type):
        type = type.value_type  # pyright: ignore[reportAttributeAccessIssue]
    return pa.types.is_integer(type) or pa.types.is_floating(type) or pa.types.is_boolean(type)


def row_hashes(array: pa.Array, dims: Sequence[int] | None = None) -> Hashes:
    """(n,) of the rows of a column: -0.0 is 0.0, every NaN is one, 1 is 1.0 and true.

    Args:
        dims: which of its numbers; None are all.
    """
    values = numbers(array)
    if values is not None and (dims is None or max(dims, default=-1) < values.shape[1]):
        bits = _bits(values if dims is None else values[:, list(dims)])
        return joined_hashes(list(bits.T), len(array))
    if array.null_count and _is_list(array.type):
        found = np.zeros(len(array), np.uint64)
        there = array.is_valid().to_numpy(zero_copy_only=False)
        found[there] = row_hashes(array.drop_null(), dims)
        return found
    return np.array([_hash(_plain(value)) for value in array.to_pylist()], np.uint64)


def joined_hashes(columns: Sequence[Hashes], count: int) -> Hashes:
    """(count,) of rows whose columns are these, by the finalizer of SplitMix64."""
    mixed = np.zeros(count, np.uint64)
    for column in columns:
        mixed = mixed + column + np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        mixed = mixed ^ (mixed >> np.uint64(31))
    return mixed


def digest(parts: Iterable[Hashes]) -> bytes:
    """Of stretches of rows: their order counts, and which part they are in."""
    whole = hashlib.blake2b(digest_size=16)
    for part in parts:
        whole.update(len(part).to_bytes(8, "little"))
        whole.update(np.ascontiguousarray(part).tobytes())
    return whole.digest()


def text_hash(text: str) -> int:
    return _hash(text.encode("utf-8", "surrogatepass"))


def _hash(content: bytes) -> int:
    return int.from_bytes(hashlib.blake2b(content, digest_size=8).digest(), "little")


def _bits(values: NDArray) -> Hashes:
    floats = values.astype(np.float64) + 0.0  # -0.0 becomes 0.0
    floats[np.isnan(floats)] = np.nan
    bits = floats.view(np.uint64)
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8:
        large = np.abs(floats) >= EXACT
        bits = np.where(large, values.astype(np.uint64), bits)
    return bits


def _plain(value: Any) -> bytes:
    if isinstance(value, dict) and value.get("bytes") is not None:
        value = value["bytes"]  # of a picture; its path is where it once lay
    return value if isinstance(value, bytes) else repr(value).encode("utf-8", "surrogatepass")


def _is_list(type: pa.DataType) -> bool:
    return (
        pa.types.is_list(type) or pa.types.is_large_list(type) or pa.types.is_fixed_size_list(type)
    )
