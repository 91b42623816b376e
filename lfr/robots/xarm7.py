"""UFACTORY xArm7."""

from lfr.robots.grippers import XARM7_GRIPPER
from lfr.robots.repair import Repair
from lfr.robots.robot import Robot

_JOINTS = tuple(f"robot0_joint{i}" for i in range(1, 8))

XARM7 = Robot(
    name="xarm7",
    stock_name="XArm7",
    joints=_JOINTS,
    gripper=XARM7_GRIPPER,
    joint_scale=(0.08, 0.08, 0.10, 0.12, 0.25, 0.25, 0.40),
    distal_bodies=("robot0_link5", "robot0_link6", "robot0_link7", "robot0_right_hand"),
    repair=Repair(
        # robosuite has it on link 1: the axes of Cartesian actions would turn with the arm.
        sites_in_base=("robot0_right_center",),
        # Ten times the other arms': the hand stalls where a motion is small.
        attributes=tuple(("joint", joint, "frictionloss", "0.1") for joint in _JOINTS),
    ),
)
