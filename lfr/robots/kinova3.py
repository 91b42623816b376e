"""Kinova Gen3."""

from lfr.robots.grippers import ROBOTIQ_85
from lfr.robots.robot import Robot

KINOVA3 = Robot(
    name="kinova3",
    stock_name="Kinova3",
    joints=tuple(f"robot0_Actuator{i}" for i in range(1, 8)),
    gripper=ROBOTIQ_85,
    joint_scale=(0.08, 0.08, 0.10, 0.12, 0.25, 0.25, 0.40),
    distal_bodies=(
        *("robot0_SphericalWrist1_Link", "robot0_SphericalWrist2_Link", "robot0_Bracelet_Link"),
        "robot0_right_hand",
    ),
)
