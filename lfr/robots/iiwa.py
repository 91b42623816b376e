"""KUKA LBR iiwa."""

from lfr.robots.grippers import ROBOTIQ_140
from lfr.robots.repair import Repair
from lfr.robots.robot import Robot

IIWA = Robot(
    name="iiwa",
    stock_name="IIWA",
    joints=tuple(f"robot0_joint_{i}" for i in range(1, 8)),
    gripper=ROBOTIQ_140,
    joint_scale=(0.09, 0.08, 0.08, 0.06, 0.21, 0.13, 0.40),
    distal_bodies=(
        *("robot0_link_5", "robot0_link_6", "robot0_link_7"),
        "robot0_right_hand",
    ),
    repair=Repair(
        why=(
            "The site that gives Cartesian actions their axes is on its first link and turns with "
            "it; it is moved to the base.",
        ),
        sites_in_base=("robot0_right_center",),
    ),
)
