"""Kinova Jaco, with its hand of three fingers."""

from lfr.robots.grippers import JACO_HAND
from lfr.robots.robot import Robot

JACO = Robot(
    name="jaco",
    stock_name="Jaco",
    joints=tuple(f"robot0_j2s7s300_joint_{i}" for i in range(1, 8)),
    gripper=JACO_HAND,
    joint_scale=(0.08, 0.08, 0.10, 0.12, 0.25, 0.25, 0.40),
    distal_bodies=(
        *("robot0_j2s7s300_link_5", "robot0_j2s7s300_link_6", "robot0_j2s7s300_link_7"),
        "robot0_right_hand",
    ),
)
