"""Franka Emika Panda."""

from lfr.robots.grippers import PANDA_GRIPPER
from lfr.robots.robot import Robot

PANDA = Robot(
    name="panda",
    stock_name="Panda",
    joints=tuple(f"robot0_joint{i}" for i in range(1, 8)),
    gripper=PANDA_GRIPPER,
    joint_scale=(0.08, 0.08, 0.10, 0.12, 0.25, 0.25, 0.40),
    distal_bodies=("robot0_link5", "robot0_link6", "robot0_link7", "robot0_right_hand"),
)
