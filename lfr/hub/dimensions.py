"""Unit, frame and meaning of every dimension, group by group, as docs/data.md has them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

BASE = "robot's base"

# k of a yaw's cosine and sine of k times the angle: the rotational symmetry of what is turned.
SYMMETRY = {"cube_yaw": 4, "cubeA_yaw": 4, "nut_yaw": 2, "nut_peg_yaw": 4}


@dataclass(frozen=True)
class Meaning:
    """What a group of dimensions is; an empty unit or frame is none."""

    unit: str
    frame: str
    about: str


KNOWN = {
    "eef_pos": Meaning("m", BASE, "position of the grip site"),
    "eef_rot6d": Meaning(
        "", BASE, "rotation of the grip site: first column of its matrix, then the second"
    ),
    "gripper_aperture": Meaning("m", "", "gap between the pads of the fingers"),
    "gripper_command": Meaning("[-1, 1]", "", "command that the gripper integrates, +1 closed"),
    "dx dy dz": Meaning(
        "0.05 m", BASE, "translation of the controller's goal from the pose achieved"
    ),
    "drx dry drz": Meaning("0.5 rad", BASE, "rotation vector of that goal"),
    "gripper": Meaning("[-1, 1]", "", "positive closes; ten steps of 1 are the full travel"),
}
ACTION_GROUPS = {name: group for group in KNOWN for name in group.split()}


def groups(names: Sequence[str]) -> Iterator[tuple[str, Meaning | None]]:
    """Neighbouring dimensions that belong together, and what they are (None: not known).

    `eef_pos.x`, `eef_pos.y`, `eef_pos.z` give one group, called "eef_pos .x .y .z".
    """
    for group, members in groupby(names, key=_group):
        parts = [name.partition(".")[2] for name in members]
        shown = " ".join([group, *(f".{part}" for part in parts if part)])
        yield shown, meaning(group)


def meaning(group: str) -> Meaning | None:
    """What a group such as "cube_to_eef" is; None where its name does not say."""
    if group in KNOWN:
        return KNOWN[group]
    if "_to_" in group:
        start, end = group.split("_to_")
        if end == "eef":  # docs/data.md: mind the sign
            start, end = "grip site", start
        return Meaning("m", BASE, f"vector from {start} to {end}")
    if group.endswith("_pos"):
        return Meaning("m", BASE, f"position of {group.removesuffix('_pos')}")
    if group.endswith("_up"):
        return Meaning("", BASE, f"unit vector: own z axis of {group.removesuffix('_up')}")
    if group in SYMMETRY:
        turned, reference = ("nut", "peg") if group == "nut_peg_yaw" else (group[:-4], "gripper")
        times = f"cosine and sine of {SYMMETRY[group]} times"
        return Meaning(
            "", BASE, f"{times} the angle about z from {reference}'s x axis to {turned}'s"
        )
    return None


def _group(name: str) -> str:
    return ACTION_GROUPS.get(name, name.partition(".")[0])
