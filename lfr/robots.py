"""What an arm is: the names and the gripper geometry of each robot that the project knows."""

from dataclasses import dataclass

from lfr.errors import UnknownNameError

ACTION_NAMES: tuple[str, ...] = ("dx", "dy", "dz", "drx", "dry", "drz", "gripper")
"""`action`: OSC_POSE deltas in [-1, 1] (0.05 m and 0.5 rad each), gripper (+1 closes)."""


@dataclass(frozen=True)
class Robot:
    """One arm with its default robosuite gripper.

    Joint, geom and body names are those of robosuite's MJCF (prefix `robot0_` for the arm,
    `gripper0_right_` for the gripper).

    Attributes:
        name: this project's name of the arm.
        stock_name: robosuite's name of it.
        joints: the seven arm joints, from the base to the wrist.
        finger_joints: the two slide joints; opening raises the first and lowers the second.
        pad_gap_at_zero: distance between the pads' inner faces (m) when both joints are at 0.
        left_pads: collision geoms of the left finger's pad, as in robosuite's grasp check.
        right_pads: the same for the right finger.
        close_signs: sign of each gripper actuator, in actuator order, that closes the hand.
        excluded_contacts: pairs of bodies whose contact is switched off, here and in stock
            environments. Sawyer's `link0` starts in contact with its own base, and the friction
            holds joint 0 against the torques that the controller asks of it.
        distal_bodies: arm bodies that keep their collision geoms in the compiled engine.
    """

    name: str
    stock_name: str
    joints: tuple[str, ...]
    finger_joints: tuple[str, str]
    pad_gap_at_zero: float
    left_pads: tuple[str, ...]
    right_pads: tuple[str, ...]
    close_signs: tuple[float, float]
    excluded_contacts: tuple[tuple[str, str], ...]
    distal_bodies: tuple[str, ...]

    base_body: str = "robot0_base"
    controller_site: str = "robot0_right_center"
    grip_site: str = "gripper0_right_grip_site"


ROBOTS: dict[str, Robot] = {
    "panda": Robot(
        name="panda",
        stock_name="Panda",
        joints=tuple(f"robot0_joint{i}" for i in range(1, 8)),
        finger_joints=("gripper0_right_finger_joint1", "gripper0_right_finger_joint2"),
        # pads at +-(8.5 - 5.0) mm, half thickness 4 mm: the inner faces overlap by 1 mm at zero
        pad_gap_at_zero=-0.001,
        left_pads=("gripper0_right_finger1_pad_collision",),
        right_pads=("gripper0_right_finger2_pad_collision",),
        close_signs=(-1.0, 1.0),
        excluded_contacts=(),
        distal_bodies=("robot0_link5", "robot0_link6", "robot0_link7", "robot0_right_hand"),
    ),
    "sawyer": Robot(
        name="sawyer",
        stock_name="Sawyer",
        joints=tuple(f"robot0_right_j{i}" for i in range(7)),
        finger_joints=("gripper0_right_l_finger_joint", "gripper0_right_r_finger_joint"),
        # fingers at +-10 mm, tips at +-17.25 mm, pads back by 4.7 mm, half thickness 4 mm
        pad_gap_at_zero=0.0371,
        left_pads=("gripper0_right_l_fingerpad_g0",),
        right_pads=("gripper0_right_r_fingerpad_g0",),
        close_signs=(1.0, -1.0),
        excluded_contacts=(("robot0_right_arm_base_link", "robot0_right_l0"),),
        distal_bodies=(
            "robot0_right_l4",
            "robot0_right_l5",
            "robot0_right_l6",
            "robot0_right_hand",
        ),
    ),
}


def robot(name: str) -> Robot:
    """The robot called `name`.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in ROBOTS:
        raise UnknownNameError("robot", name, tuple(ROBOTS))
    return ROBOTS[name]
