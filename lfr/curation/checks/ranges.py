"""Bounds of named dimensions that this project's layouts set."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from lfr.curation.features import names_of
from lfr.data.episode import ACTION, JOINT_POSITION
from lfr.robots import ACTION_NAMES

Bounds = tuple[float, float]

REACH = 3.0  # m: no arm of the project, and nothing on its table, is further from its base
TURN = 2 * math.pi  # rad: joints of either arm stay within a full turn

# The last part of a group's name, in observation.state and observation.environment_state.
GROUPS: Mapping[str, Bounds] = {
    "_pos": (-REACH, REACH),
    "_to_eef": (-REACH, REACH),
    "_up": (-1.0, 1.0),
    "_yaw": (-1.0, 1.0),
    "_rot6d": (-1.0, 1.0),
}
NAMED: Mapping[str, Bounds] = {"gripper_aperture": (-0.01, 0.5), "gripper_command": (-1.0, 1.0)}


def bounds(key: str, features: Mapping[str, Mapping[str, Any]]) -> dict[int, Bounds]:
    """Dimension of the feature `key` -> its smallest and largest value.

    Nothing for a dataset whose action is not this project's: its lengths may be millimetres.
    """
    if not _ours(features):
        return {}
    names = names_of(features[key])
    if key == ACTION:
        return dict.fromkeys(range(len(names)), (-1.0, 1.0))
    if key == JOINT_POSITION:
        return dict.fromkeys(range(len(names)), (-TURN, TURN))
    if not key.startswith("observation."):
        return {}
    found = {i: NAMED[name] for i, name in enumerate(names) if name in NAMED}
    for i, name in enumerate(names):
        group, dot, _ = name.partition(".")
        for suffix, bound in GROUPS.items():
            if dot and group.endswith(suffix):
                found[i] = bound
    return found


def _ours(features: Mapping[str, Mapping[str, Any]]) -> bool:
    return tuple(names_of(features.get(ACTION, {}))) == ACTION_NAMES
