"""Policies for Fetch, which has none of its own; Meta-World's are `metaworld.policies`.

They know no more than what is observed, as Meta-World's do, and go the same way: above the object,
down to it, close, to the goal.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

GAIN = 10.0  # of 5 cm, per metre
NEAR, HELD, WIDE = (
    0.02,
    0.03,
    0.027,
)  # m: beside it, within the fingers, their way when they hold it
ABOVE = np.array([0.0, 0.0, 0.1])
OPEN, CLOSED = 1.0, -1.0

Action = NDArray[np.float64]


def reach() -> Any:
    """To the goal."""
    return lambda observed: _towards(observed, observed["desired_goal"], OPEN)


def place() -> Any:
    """To the object, and with it to the goal; on the table it drags it."""
    return _place


def _place(observed: dict[str, NDArray[np.float64]]) -> Action:
    state, goal = observed["observation"], observed["desired_goal"]
    hand, thing, way = state[:3], state[3:6], state[9]
    if np.linalg.norm((thing - hand)[:2]) > NEAR:
        return _towards(observed, thing + ABOVE, OPEN)
    if np.linalg.norm(thing - hand) > NEAR:
        return _towards(observed, thing, OPEN)
    if way > WIDE:
        return _towards(observed, thing, CLOSED)
    return _towards(observed, goal + hand - thing, CLOSED)


def _towards(observed: dict[str, NDArray[np.float64]], place: Action, gripper: float) -> Action:
    way = GAIN * (place - observed["observation"][:3])
    return np.clip([*way, gripper], -1.0, 1.0)
