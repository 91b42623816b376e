"""Universal Robots UR5e, of six joints."""

from lfr.robots.grippers import ROBOTIQ_85
from lfr.robots.robot import Robot

UR5E = Robot(
    name="ur5e",
    stock_name="UR5e",
    joints=tuple(
        f"robot0_{name}_joint"
        for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    ),
    gripper=ROBOTIQ_85,
    joint_scale=(0.08, 0.08, 0.10, 0.25, 0.25, 0.40),
    distal_bodies=(
        *("robot0_wrist_1_link", "robot0_wrist_2_link", "robot0_wrist_3_link"),
        "robot0_right_hand",
    ),
)
