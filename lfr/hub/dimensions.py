"""What the dimensions of a column are, as the rows of a card's table."""

from __future__ import annotations

from collections.abc import Iterator

from lfr.spaces import Quantity, Space

Row = tuple[str, str, str, str]
"""Dimensions, unit of a value of 1, frame, meaning; an empty unit or frame is none."""


def rows(space: Space) -> Iterator[Row]:
    """A row for each quantity; one for each of its dimensions where a 1 of these differs.

    `eef_pos.x`, `eef_pos.y`, `eef_pos.z` are shown as "`eef_pos .x .y .z`".
    """
    for quantity in space.quantities:
        scales = quantity.scale or (1.0,) * quantity.size
        if len(set(scales)) == 1:
            yield _row(_shown(quantity), quantity, scales[0])
        else:
            for name, scale in zip(quantity.names, scales, strict=True):
                yield _row(f"`{name}`", quantity, scale)


def _row(shown: str, quantity: Quantity, scale: float) -> Row:
    unit = quantity.unit if scale == 1.0 else f"{scale:g} {quantity.unit}"
    return shown, unit, quantity.frame, quantity.about


def _shown(quantity: Quantity) -> str:
    stem = f"{quantity.name}."
    names = quantity.names
    if names[0].startswith(stem):
        return f"`{' '.join([quantity.name, *(f'.{part}' for part in quantity.parts)])}`"
    return f"`{' '.join(names)}`" if len(names) <= 3 else f"`{names[0]}` to `{names[-1]}`"
