"""Rethink Robotics Sawyer."""

from lfr.robots.grippers import RETHINK_GRIPPER
from lfr.robots.repair import Repair
from lfr.robots.robot import Robot

SAWYER = Robot(
    name="sawyer",
    stock_name="Sawyer",
    joints=tuple(f"robot0_right_j{i}" for i in range(7)),
    gripper=RETHINK_GRIPPER,
    joint_scale=(0.09, 0.10, 0.10, 0.07, 0.21, 0.17, 0.40),
    distal_bodies=(
        *("robot0_right_l4", "robot0_right_l5", "robot0_right_l6"),
        "robot0_right_hand",
    ),
    repair=Repair(
        why=(
            "Its first link starts in contact with its own base, and the friction holds the first "
            "joint against the controller; the contact is switched off.",
        ),
        excluded_contacts=(("robot0_right_arm_base_link", "robot0_right_l0"),),
    ),
)
