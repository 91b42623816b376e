"""Bounds of named dimensions that this project's layouts set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lfr.data.episode import ACTION, JOINT_POSITION
from lfr.data.features import names_of
from lfr.embodiments import known_action
from lfr.errors import UnknownNameError
from lfr.spaces import Quantity, joint_position, quantity, quantity_name

Bounds = tuple[float, float]


def bounds(
    key: str, features: Mapping[str, Mapping[str, Any]], robot: str = ""
) -> dict[int, Bounds]:
    """Dimension of the feature `key` -> its smallest and largest value, of a robot's dataset.

    Nothing for a dataset whose action is no known embodiment's: its lengths may be millimetres.
    Nor for a dimension that no name explains.
    """
    action = known_action(tuple(names_of(features.get(ACTION, {}))), robot)
    if action is None:
        return {}
    names = names_of(features[key])
    if key == ACTION:
        known: tuple[Quantity | None, ...] = action.each()
    elif key == JOINT_POSITION:
        known = (joint_position(names),) * len(names)
    elif key.startswith("observation."):
        known = tuple(map(_quantity, names))
    else:
        known = ()
    return {place: (each.low, each.high) for place, each in enumerate(known) if each}


def _quantity(name: str) -> Quantity | None:
    try:
        return quantity(quantity_name(name))
    except UnknownNameError:
        return None
