"""What an arm and what a gripper is, by the names that robosuite's MJCF gives their parts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from lfr.robots.repair import Repair


@dataclass(frozen=True)
class Mount:
    """Where a camera stands on the hand, beside its axis and looking along it.

    Attributes:
        position: (3,) m, in the frame of the body `robot0_right_hand`, whose z axis is the
            approach; the picture's upper edge is towards its x axis.
        tilt: degrees by which it looks down from there, towards the axis.
    """

    position: tuple[float, float, float]
    tilt: float

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """(4,) wxyz, of MuJoCo's camera frame: x right, y up, -z ahead."""
        half = 0.5 * math.radians(self.tilt)
        s, c = math.sqrt(0.5) * math.sin(half), math.sqrt(0.5) * math.cos(half)
        return s, c, c, s


@dataclass(frozen=True)
class Gripper:
    """A gripper with one command for all its fingers, however many move.

    Names are those of robosuite's MJCF, with its prefix `gripper0_right_`. The grip site is between
    the pads; its z axis is the approach, its x axis the closing axis.

    Attributes:
        name: this project's name of it.
        stock_name: robosuite's name of its class.
        joints: all finger joints, in the order of qpos.
        opened: their positions with the hand open.
        closed: the same with the hand closed on nothing.
        left_pads: collision geoms of one finger's pad, or of the pads on one side.
        right_pads: the same for the other side.
        pad_axis: of a pad's box, the axis that is its thickness.
        close_signs: sign of each actuator, in actuator order, that closes the hand.
        speed: of the command that is integrated, per control step; full travel is 2.
        stock_speed: robosuite's own, where it is another.
        stock_knows_pads: whether robosuite's grasp check asks for pads that its model has.
        repair: of robosuite's model.
        wrist_camera: where robosuite's camera of the hand sees too little of the fingers.
    """

    name: str
    stock_name: str
    joints: tuple[str, ...]
    opened: tuple[float, ...]
    closed: tuple[float, ...]
    left_pads: tuple[str, ...]
    right_pads: tuple[str, ...]
    close_signs: tuple[float, ...]
    speed: float = 0.2
    stock_speed: float = 0.2
    stock_knows_pads: bool = True
    pad_axis: int = 1
    repair: Repair = field(default_factory=Repair)
    wrist_camera: Mount | None = None
    grip_site: str = "gripper0_right_grip_site"

    def __post_init__(self) -> None:
        for what in ("opened", "closed"):
            _check_length(self.name, what, getattr(self, what), self.joints)


@dataclass(frozen=True)
class Robot:
    """One arm with its default gripper.

    Attributes:
        name: this project's name of the arm.
        stock_name: robosuite's name of it.
        joints: the arm's hinges, from the base to the wrist, with robosuite's prefix `robot0_`;
            the first one is vertical.
        gripper: its default one.
        joint_scale: (N,) rad that an action of 1 moves each joint under joint position control:
            about 45 mm at the hand, a turn of it counted at 0.1 m, whichever joint it is; at most
            0.4 rad.
        distal_bodies: arm bodies that keep their collision geoms in the compiled engine.
        repair: of robosuite's model of the arm; its gripper has its own.
    """

    name: str
    stock_name: str
    joints: tuple[str, ...]
    gripper: Gripper
    joint_scale: tuple[float, ...]
    distal_bodies: tuple[str, ...]
    repair: Repair = field(default_factory=Repair)
    base_body: str = "robot0_base"
    controller_site: str = "robot0_right_center"

    def __post_init__(self) -> None:
        if "-" in self.name:
            raise ValueError(
                f"{self.name}: no '-' in the name of an arm; it parts off the controller"
            )
        _check_length(self.name, "joint_scale", self.joint_scale, self.joints)

    @property
    def title(self) -> str:
        """Its name in words: robosuite's, where the arm is robosuite's with its default gripper."""
        if self.stock_name.lower() == self.name:
            return self.stock_name
        return "".join(word.capitalize() for word in self.name.split("_"))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints without robosuite's prefix."""
        return tuple(joint.removeprefix("robot0_") for joint in self.joints)

    @property
    def repairs(self) -> Repair:
        """Of the arm and of its gripper."""
        return self.repair + self.gripper.repair

    def repaired(self, xml: str) -> str:
        """robosuite's MJCF of this arm with its gripper, mended."""
        return self.repairs.applied(xml)


def _check_length(name: str, what: str, values: tuple[float, ...], joints: tuple[str, ...]) -> None:
    if len(values) != len(joints):
        raise ValueError(f"{name}: {what} has {len(values)} values for {len(joints)} joints")
