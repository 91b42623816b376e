"""What an arm and what a gripper is, by the names that robosuite's MJCF gives their parts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Gripper:
    """A gripper with one command for all its fingers.

    Names are those of robosuite's MJCF, with its prefix `gripper0_right_`.

    Attributes:
        name: this project's name of it.
        stock_name: robosuite's name of its class.
        joints: all finger joints, in the order of qpos.
        finger_joints: the two slide joints; opening raises the first and lowers the second.
        pad_gap_at_zero: distance between the pads' inner faces (m) when both joints are at 0.
        left_pads: collision geoms of the left finger's pad, as in robosuite's grasp check.
        right_pads: the same for the right finger.
        close_signs: sign of each actuator, in actuator order, that closes the hand.
        speed: of the command that robosuite integrates, per control step; full travel is 2.
        grip_site: between the pads; its z axis is the approach, its x axis the closing axis.
    """

    name: str
    stock_name: str
    joints: tuple[str, ...]
    finger_joints: tuple[str, str]
    pad_gap_at_zero: float
    left_pads: tuple[str, ...]
    right_pads: tuple[str, ...]
    close_signs: tuple[float, ...]
    speed: float = 0.2
    grip_site: str = "gripper0_right_grip_site"


@dataclass(frozen=True)
class Robot:
    """One arm with its default gripper.

    Attributes:
        name: this project's name of the arm.
        stock_name: robosuite's name of it.
        joints: the arm's hinges, from the base to the wrist, with robosuite's prefix `robot0_`.
        gripper: its default one.
        joint_scale: (N,) rad that an action of 1 moves each joint under joint position control.
        distal_bodies: arm bodies that keep their collision geoms in the compiled engine.
        excluded_contacts: pairs of bodies whose contact is switched off, here and in stock
            environments.
    """

    name: str
    stock_name: str
    joints: tuple[str, ...]
    gripper: Gripper
    joint_scale: tuple[float, ...]
    distal_bodies: tuple[str, ...]
    excluded_contacts: tuple[tuple[str, str], ...] = ()
    base_body: str = "robot0_base"
    controller_site: str = "robot0_right_center"

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints without robosuite's prefix."""
        return tuple(joint.removeprefix("robot0_") for joint in self.joints)
