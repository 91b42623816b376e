"""What an episode's action is, and what its quantities are called for people."""

from __future__ import annotations

from lfr.data.episode import ACTION, Episode
from lfr.embodiments import known_action
from lfr.spaces import Quantity, Space, gripper_action

GRIPPER = gripper_action().name
"""Of a known embodiment's action, the quantity that moves no arm."""


def own_action(episode: Episode) -> Space | None:
    """What the action is, where it is a known embodiment's; of any other, names say nothing."""
    return known_action(episode.schema[ACTION].names or (), episode.robot)


def motion_title(moved: Quantity) -> str:
    """A quantity and what a value of 1 asks for: `Action: dq (1 = 0.08 to 0.4 rad)`."""
    sizes = dict.fromkeys((min(moved.scale), max(moved.scale))) if moved.scale else ()
    said = " to ".join(f"{size:g}" for size in sizes)
    return f"Action: {moved.name} (1 = {said} {moved.unit})" if said else f"Action: {moved.name}"
