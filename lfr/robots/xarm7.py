"""UFACTORY xArm7."""

from lfr.robots.grippers import XARM7_GRIPPER
from lfr.robots.repair import NEARER, Repair
from lfr.robots.robot import Robot

_JOINTS = tuple(f"robot0_joint{i}" for i in range(1, 8))

XARM7 = Robot(
    name="xarm7",
    stock_name="XArm7",
    joints=_JOINTS,
    gripper=XARM7_GRIPPER,
    joint_scale=(0.09, 0.09, 0.09, 0.09, 0.22, 0.17, 0.40),
    distal_bodies=("robot0_link5", "robot0_link6", "robot0_link7", "robot0_right_hand"),
    repair=Repair(
        why=(
            "The site that gives Cartesian actions their axes is on its first link and turns with "
            "it; it is moved to the base.",
            "Its joints have ten times the friction of other arms, and small motions stall; it is "
            "theirs.",
        ),
        sites_in_base=("robot0_right_center",),
        attributes=tuple(("joint", joint, "frictionloss", "0.1") for joint in _JOINTS),
    )
    + NEARER,
)
