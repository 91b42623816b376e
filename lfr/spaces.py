"""What a dimension is: unit, frame, bounds, and how it changes when the whole scene is moved.

Observations and actions are vectors of named dimensions; neighbouring ones that belong together are
a `Quantity` (`cube_pos` is `cube_pos.x`, `cube_pos.y`, `cube_pos.z`), and a `Space` is a sequence
of these. Whoever needs to know what a dimension means asks here, and gets the same answer: the
kernel's observation, normalisation, moved copies of demonstrations, checks, cards and views.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import groupby
from typing import Literal

from lfr.errors import UnknownNameError

Moves = Literal[
    "point",
    "vector",
    "axial",
    "rotation",
    "relative angle",
    "not at all",
    "with the base",
    "unknown",
]
"""How a quantity changes when the scene is turned about the vertical, mirrored or shifted.

As a point, a vector, an axial vector (a rotation vector), or the first two columns of a rotation
matrix; as cosine and sine of an angle between two things of the scene, which a mirror alone
changes; not at all; not by a turn about the base's vertical, and in no known way by anything else;
or in no known way.
"""

BASE = "robot's base"
XYZ = ("x", "y", "z")

FULL_TURN = 2.0 * math.pi
"""rad: the joints of all arms here stay within a full turn."""

REACH = 3.0
"""m: no arm here, and nothing on its table, is further from its base."""


@dataclass(frozen=True)
class Quantity:
    """Neighbouring dimensions that mean one thing.

    Attributes:
        name: such as "cube_pos".
        names: of its dimensions, in order.
        unit: of a value of 1; "" for none.
        frame: that its components are given in; "" for none.
        about: in words.
        moves: see `Moves`.
        low, high: bounds that no sound value leaves.
        std_floor: floor under the standard deviation by which it is normalised, in its unit. What
            hardly varies in the demonstrations (an orientation, a gripper that is open at the
            start) must not be blown up: another arm will leave that narrow range.
        to_zero: whether it is a vector that a task brings to zero.
        fold: k of cosine and sine of k times an angle, the rotational symmetry of what is turned.
        scale: of an action, what a value of 1 asks for, in ``unit``, for each dimension; () is 1.
    """

    name: str
    names: tuple[str, ...]
    unit: str
    frame: str
    about: str
    moves: Moves
    low: float
    high: float
    std_floor: float
    to_zero: bool = False
    fold: int = 1
    scale: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        return len(self.names)

    @property
    def parts(self) -> tuple[str, ...]:
        """What tells its dimensions apart: ("x", "y", "z"); ("",) of a single one."""
        return tuple(name.removeprefix(self.name).lstrip(".") for name in self.names)


@dataclass(frozen=True)
class Space:
    """Quantities one after the other, and where each stands in a vector (D,)."""

    quantities: tuple[Quantity, ...]

    def __post_init__(self) -> None:
        twice = [name for name in self.names if self.names.count(name) > 1]
        if twice:
            raise ValueError(f"{', '.join(dict.fromkeys(twice))} more than once")

    def __add__(self, other: Space) -> Space:
        return Space(self.quantities + other.quantities)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all dimensions."""
        return tuple(name for quantity in self.quantities for name in quantity.names)

    @property
    def size(self) -> int:
        return sum(quantity.size for quantity in self.quantities)

    def items(self) -> Iterator[tuple[Quantity, slice]]:
        """Each quantity, and where it stands."""
        start = 0
        for quantity in self.quantities:
            yield quantity, slice(start, start + quantity.size)
            start += quantity.size

    def each(self) -> tuple[Quantity, ...]:
        """(D,): the quantity of each dimension."""
        return tuple(quantity for quantity in self.quantities for _ in quantity.names)

    def index(self, name: str) -> int:
        """Position of one dimension, such as "cube_pos.z".

        Raises:
            UnknownNameError: no dimension has that name.
        """
        if name not in self.names:
            raise UnknownNameError("dimension", name, self.names)
        return self.names.index(name)

    def slice(self, name: str) -> slice:
        """Where the quantity called ``name`` stands.

        Raises:
            UnknownNameError: there is none.
        """
        for quantity, place in self.items():
            if quantity.name == name:
                return place
        raise UnknownNameError("quantity", name, (q.name for q in self.quantities))


def _vector(
    name: str, about: str, unit: str, moves: Moves, bound: float, std_floor: float
) -> Quantity:
    names = tuple(f"{name}.{axis}" for axis in XYZ)
    return Quantity(name, names, unit, BASE, about, moves, -bound, bound, std_floor)


def _called(thing: str) -> str:
    return "the grip site" if thing == "eef" else thing


def position(thing: str, about: str = "") -> Quantity:
    """Where a thing is: ``<thing>_pos``."""
    about = about or f"position of {thing}"
    return _vector(f"{thing}_pos", about, "m", "point", REACH, std_floor=0.05)


def axis(thing: str) -> Quantity:
    """Which way a thing's own z axis points: ``<thing>_up``."""
    about = f"unit vector: own z axis of {thing}"
    return _vector(f"{thing}_up", about, "", "vector", 1.0, std_floor=0.2)


def displacement(start: str, end: str) -> Quantity:
    """The vector from one thing to another: ``<start>_to_<end>``."""
    about = f"vector from {_called(start)} to {_called(end)}"
    vector = _vector(f"{start}_to_{end}", about, "m", "vector", REACH, std_floor=0.05)
    return replace(vector, to_zero=True)


def rotation(thing: str, about: str = "") -> Quantity:
    """A rotation as the first two columns of its matrix: ``<thing>_rot6d``."""
    about = about or f"rotation of {thing}"
    name = f"{thing}_rot6d"
    names = tuple(f"{name}.{i}" for i in range(6))
    about = f"{about}: first column of its matrix, then the second"
    return Quantity(name, names, "", BASE, about, "rotation", -1.0, 1.0, 0.2)


def yaw(name: str, turned: str = "it", reference: str = "the gripper", fold: int = 1) -> Quantity:
    """The angle about the vertical between two x axes, as cosine and sine: ``<name>_yaw``.

    Args:
        fold: k, the rotational symmetry of what is turned; cosine and sine are of k times it.
    """
    about = f"cosine and sine of {fold} times the angle about z from {reference}'s x axis"
    name = f"{name}_yaw"
    return Quantity(
        name, (f"{name}.cos", f"{name}.sin"), "", BASE, f"{about} to {turned}'s",
        "relative angle", -1.0, 1.0, 0.3, fold=fold,
    )  # fmt: skip


def gripper_aperture() -> Quantity:
    about = "gap between the pads of the fingers"
    name = "gripper_aperture"
    return Quantity(name, (name,), "m", "", about, "not at all", -0.01, 0.5, 0.01)


def gripper_command() -> Quantity:
    about = "command that the gripper integrates, +1 closed"
    name = "gripper_command"
    return Quantity(name, (name,), "", "", about, "not at all", -1.0, 1.0, 0.3)


def gripper_action() -> Quantity:
    about = "positive closes the gripper, negative opens it"
    return Quantity("gripper", ("gripper",), "", "", about, "not at all", -1.0, 1.0, 0.3)


def translation(scale: Sequence[float] = ()) -> Quantity:
    """Of an action: what moves the end effector's goal from the pose achieved."""
    about = "translation of the end effector's goal from the pose achieved"
    names = ("dx", "dy", "dz")
    return Quantity(
        "translation", names, "m", BASE, about, "vector", -1.0, 1.0, 0.3, scale=tuple(scale)
    )


def turn(scale: Sequence[float] = ()) -> Quantity:
    """Of an action: what turns the end effector's goal from the pose achieved."""
    about = "rotation vector of that goal"
    names = ("drx", "dry", "drz")
    return Quantity(
        "rotation", names, "rad", BASE, about, "axial", -1.0, 1.0, 0.3, scale=tuple(scale)
    )


def joint_motion(joints: Sequence[str], scale: Sequence[float] = ()) -> Quantity:
    """Of an action: what moves each joint's goal from the position achieved: ``dq.<joint>``."""
    about = "motion of each joint's goal from the position achieved"
    names = tuple(f"dq.{joint}" for joint in joints)
    return Quantity(
        "dq", names, "rad", "", about, "with the base", -1.0, 1.0, 0.3, scale=tuple(scale)
    )


def joint_position(joints: Sequence[str]) -> Quantity:
    """Angles of an arm's joints, rad, as ``observation.joint_position`` has them."""
    about = "arm joint angles, base to wrist"
    return Quantity(
        "joint_position", tuple(joints), "rad", "", about, "unknown", -FULL_TURN, FULL_TURN, 0.2
    )


ROBOT_STATE = Space(
    (
        position("eef", "position of the grip site"),
        rotation("eef", "rotation of the grip site"),
        gripper_aperture(),
        gripper_command(),
    )
)
"""`observation.state`, the same for every arm, in the base frame."""

NUMBER = Quantity("number", (), "", "", "not said", "unknown", -math.inf, math.inf, 0.05)
"""Any number: what is meant by `number.<name>`, where a dataset's own names say no more."""

JOINT = joint_position(())
"""The angles of joints called `joint.<name>`."""

_NAMED = {
    known.name: known
    for known in (
        *ROBOT_STATE.quantities,
        *(translation(), turn(), joint_motion(()), gripper_action()),
        *(NUMBER, replace(JOINT, name="joint")),
    )
}
_QUANTITY_OF = {name: known.name for known in (translation(), turn()) for name in known.names}

_FORMS: dict[str, Callable[[str], Quantity]] = {
    "pos": position,
    "rot6d": rotation,
    "up": axis,
    "yaw": yaw,
}
"""What follows the last `_` of a quantity's name, and what it makes of what stands before it."""


def quantity_name(dimension: str) -> str:
    """The name of the quantity that a dimension belongs to: "cube_pos" of "cube_pos.x"."""
    return _QUANTITY_OF.get(dimension, dimension.partition(".")[0])


def quantity(name: str) -> Quantity:
    """What a quantity called ``name`` is, by the form of its name.

    Raises:
        UnknownNameError: the name has no known form; the message lists these.
    """
    if name in _NAMED:
        return _NAMED[name]
    thing, _, form = name.rpartition("_")
    start, to, end = name.partition("_to_")
    if start and to and end:
        return displacement(start, end)
    if thing and form in _FORMS:
        return _FORMS[form](thing)
    forms = (*(f"<thing>_{form}" for form in _FORMS), "<start>_to_<end>")
    raise UnknownNameError("quantity", name, (*_NAMED, *forms))


def space(names: Sequence[str]) -> Space:
    """The space of dimensions called ``names``, such as "cube_pos.x", by the form of their names.

    Raises:
        UnknownNameError: a name has no known form.
    """
    return _space(tuple(names))


@cache
def _space(names: tuple[str, ...]) -> Space:
    found = []
    for group, members in groupby(names, key=quantity_name):
        known = quantity(group)
        found.append(replace(known, names=tuple(members)))
    return Space(tuple(found))
