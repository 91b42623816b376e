"""Joint position control, as robosuite's JOINT_POSITION computes it, compiled.

    q_d   = q + s u                       at each control step, u in [-1, 1] per joint
    tau   = M (kp (q_d - q) - kd q_dot) + b

with q the position achieved, s the arm's scale per joint (`Robot.joint_scale`), M the inertia and b
gravity, Coriolis and centrifugal forces. Source: robosuite 1.5.2,
`controllers/parts/generic/joint_pos.py`.

robosuite's own default is kp 50 and 0.05 rad for all joints. With the goal relative to the position
achieved, a joint then moves by at most sqrt(kp) / 2 x 0.05 rad = 0.18 rad/s. Here kp is OSC_POSE's,
and the scales differ by joint so that an action of 1 moves the hand about as far whichever joint it
is: a model's error in an action then counts alike for all of them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled import compiled
from lfr.compiled.arrays import Control, Physics, SceneArrays
from lfr.controllers.controller import (
    HAND_UNITS,
    Configuration,
    Controller,
)
from lfr.controllers.inertia import inertia
from lfr.robots.robot import Robot
from lfr.spaces import Quantity, joint_motion

KP = 150.0
KD = 2.0 * math.sqrt(KP)  # damping ratio 1

DAMPING = 0.03
"""Of the least squares, in m and rad alike: a stretched arm gives way instead of racing."""
RETURN = 0.15
"""Share of the way back to the rest posture that a control step asks for."""


@compiled
def set_goal(
    physics: Physics, scene: SceneArrays, control: Control, action: NDArray[np.float64]
) -> None:
    """Goal position of each joint, relative to the position achieved."""
    for j in range(control.goal_joints.shape[0]):
        delta = min(max(action[j], -1.0), 1.0) * scene.action_scale[j]
        control.goal_joints[j] = physics.qpos[j] + delta


@compiled
def set_torques(physics: Physics, scene: SceneArrays, control: Control) -> None:
    """Torques of the arm (N m) for the current state and goal, clipped to the actuators' limits."""
    joints, a = inertia(physics, scene, control), control.acceleration
    for j in range(joints):
        a[j] = KP * (control.goal_joints[j] - physics.qpos[j]) - KD * physics.qvel[j]
    for j in range(joints):
        torque = physics.bias[j]
        for k in range(joints):
            torque += control.mass[j, k] * a[k]
        physics.ctrl[j] = min(max(torque, scene.ctrl_range[j, 0]), scene.ctrl_range[j, 1])


def _motion(robot: Robot) -> tuple[Quantity, ...]:
    return (joint_motion(robot.joint_names, robot.joint_scale),)


def action_of(motion: NDArray[np.float64], at: Configuration) -> NDArray[np.float64]:
    """Joint motions (N,) that move the hand: damped least squares, the rest posture kept.

        dq = J^+ v + (I - J^+ J) r (q_0 - q),    J^+ = J^T (J J^T + d^2 I)^-1

    with v the hand's motion (m, rad), d `DAMPING`, r `RETURN` and q_0 the rest posture. So the
    joints follow from where the hand is: a learner that sees the hand alone can predict them. The
    first joint is left free, since turning about the base's vertical changes nothing else. Where a
    joint would go beyond its scale, all slow down alike, so that the hand keeps its direction.
    """
    J = at.jacobian
    inverse = J.T @ np.linalg.inv(J @ J.T + DAMPING**2 * np.eye(6))
    back = RETURN * (at.rest - at.joint_position)
    back[0] = 0.0
    wanted = motion * HAND_UNITS
    delta = (inverse @ wanted + back - inverse @ (J @ back)) / at.scale
    return delta / max(1.0, float(np.abs(delta).max()))


JOINT_POSITION = Controller(
    name="joint_position",
    stock_name="JOINT_POSITION",
    motion=_motion,
    set_goal=set_goal,
    set_torques=set_torques,
    action_of=action_of,
    stock_gains={
        "kp": KP,
        "damping_ratio": 1,
        "impedance_mode": "fixed",
        "kp_limits": [0, 300],
        "damping_ratio_limits": [0, 10],
        "qpos_limits": None,
        "ramp_ratio": 0.2,
    },
)
