"""Depth maps and other tables of numbers as pictures: scaled to the range that an episode has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL.Image import Image

SMALLEST = 8  # rows and columns of a picture; a matrix of fewer is seen as curves
DEEP = ("I;16", "I;16B", "I;16L", "I", "F")  # Pillow's modes of one number a pixel, of over 8 bits


def is_picture(shape: Sequence[int]) -> bool:
    """Whether a feature of numbers has rows and columns as a picture has: (H, W), (H, W, 1),
    (1, H, W) or (H, W, 3).
    """
    sides = [size for size in shape if size != 1]
    sides = sides[:2] if len(sides) == 3 and sides[2] == 3 else sides
    return len(sides) == 2 and min(sides) >= SMALLEST


def tensor(column: pa.ChunkedArray, shape: Sequence[int]) -> NDArray:
    """A column of nested lists as (T, *sides), without sides of 1.

    Raises:
        ValueError: they are of another size, or have gaps.
    """
    sides, count = [size for size in shape if size != 1], len(column)
    array: Any = column.combine_chunks()
    while isinstance(array, pa.ExtensionArray):  # `datasets` keeps arrays of more dimensions so
        array = array.storage
    while pa.types.is_nested(array.type):
        array = array.flatten()
    if array.null_count:
        raise ValueError(f"{array.null_count} missing values")
    return array.to_numpy(zero_copy_only=False).reshape(count, *sides)


def scaled(frames: Sequence[NDArray]) -> list[Image]:
    """Pictures of numbers, the least of all frames black and the greatest white.

    Where nothing was measured, 0 or no finite number, it is black.

    Args:
        frames: (H, W) or (H, W, 3) each.
    """
    from PIL import Image

    low, high = np.inf, -np.inf
    for frame in frames:
        known = frame[_measured(frame)]
        if known.size:
            low, high = min(low, float(known.min())), max(high, float(known.max()))
    if low > high:
        low = high = 0.0
    pictures = []
    for frame in frames:
        known = _measured(frame)
        share = (np.where(known, frame, low) - low) / ((high - low) or 1.0)
        pixels = np.where(known, np.rint(255 * share), 0).astype(np.uint8)
        pictures.append(Image.fromarray(pixels))
    return pictures


def _measured(frame: NDArray) -> NDArray[np.bool_]:
    return np.isfinite(frame) & (frame != 0)
