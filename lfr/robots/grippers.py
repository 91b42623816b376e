"""The grippers that robosuite's arms carry."""

from __future__ import annotations

from lfr.robots.robot import Gripper

PANDA_GRIPPER = Gripper(
    name="panda_gripper",
    stock_name="PandaGripper",
    joints=("gripper0_right_finger_joint1", "gripper0_right_finger_joint2"),
    finger_joints=("gripper0_right_finger_joint1", "gripper0_right_finger_joint2"),
    # pads at +-(8.5 - 5.0) mm, half thickness 4 mm: the inner faces overlap by 1 mm at zero
    pad_gap_at_zero=-0.001,
    left_pads=("gripper0_right_finger1_pad_collision",),
    right_pads=("gripper0_right_finger2_pad_collision",),
    close_signs=(-1.0, 1.0),
)

RETHINK_GRIPPER = Gripper(
    name="rethink_gripper",
    stock_name="RethinkGripper",
    joints=("gripper0_right_l_finger_joint", "gripper0_right_r_finger_joint"),
    finger_joints=("gripper0_right_l_finger_joint", "gripper0_right_r_finger_joint"),
    # fingers at +-10 mm, tips at +-17.25 mm, pads back by 4.7 mm, half thickness 4 mm
    pad_gap_at_zero=0.0371,
    left_pads=("gripper0_right_l_fingerpad_g0",),
    right_pads=("gripper0_right_r_fingerpad_g0",),
    close_signs=(1.0, -1.0),
)
