"""A run of control steps in one compiled call, with the GIL released.

One compiled specialisation serves every arm, controller and task: what differs is data
(`SceneArrays`), and the parts that are code are chosen among by number.
"""

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled import compiled
from lfr.compiled.arrays import Control, Physics, SceneArrays
from lfr.compiled.observation import observe
from lfr.controllers import set_goal, set_torques
from lfr.controllers.controller import SUBSTEPS
from lfr.sim.compilation import entry
from lfr.sim.cube import resize
from lfr.sim.engine import Engine
from lfr.sim.libmujoco import mj_kinematics, mj_resetData, mj_step1, mj_step2
from lfr.sim.start import draw
from lfr.tasks import reward_and_success

LARGEST = 1e3
"""Beyond this position (rad, m) or velocity (per s) the physics counts as diverged."""


@entry
def reset(engine: Engine, seed: int, observation: NDArray[np.float64]) -> None:
    """Start the episode that `seed` names; fill the observation (D,)."""
    physics, control, start, drawn = engine.physics, engine.control, engine.start, engine.drawn
    draw(start, seed, drawn)
    if start.sized:
        resize(engine.cube, drawn.cube_size)
    mj_resetData(physics.model, physics.data)
    joints = drawn.joint_position.shape[0]
    for j in range(joints):
        physics.qpos[j] = control.posture[j] = drawn.joint_position[j]
    # robosuite writes the open position in the order of the gripper's joints.
    for f in range(start.open_fingers.shape[0]):
        physics.qpos[joints + f] = start.open_fingers[f]
    for i in range(start.addresses.shape[0]):
        address = start.addresses[i]
        if address >= 0:
            for k in range(7):
                physics.qpos[address + k] = drawn.poses[i, k]
    control.gripper[0] = 0.0
    _current(physics, engine.scene, control, observation)


@entry
def current(engine: Engine, observation: NDArray[np.float64]) -> None:
    """Bring the kinematics up to date; fill the observation (D,)."""
    _current(engine.physics, engine.scene, engine.control, observation)


@entry
def run(
    engine: Engine,
    actions: NDArray[np.float64],
    stop_on_success: bool,
    observations: NDArray[np.float64],
    rewards: NDArray[np.float64],
    successes: NDArray[np.bool_],
) -> tuple[int, bool]:
    """Apply actions (H, A); fill observations (H, D), rewards (H,), successes (H,).

    Returns:
        The number of steps taken, and whether the last of them diverged; the observation of a
        diverged step repeats the last finite one.
    """
    physics, scene, control = engine.physics, engine.scene, engine.control
    last = actions.shape[0]
    for t in range(last):
        finite = _finite(actions[t], math.inf)
        if not finite or not _control_step(physics, scene, control, actions[t]):
            if t > 0:
                observations[t] = observations[t - 1]
            rewards[t], successes[t] = 0.0, False
            return t + 1, True
        rewards[t], successes[t] = reward_and_success(physics, scene)
        _current(physics, scene, control, observations[t])
        if stop_on_success and successes[t]:
            return t + 1, False
    return last, False


@compiled
def _current(
    physics: Physics, scene: SceneArrays, control: Control, observation: NDArray[np.float64]
) -> None:
    mj_kinematics(physics.model, physics.data)
    observe(physics, scene, control, observation)


@compiled
def _control_step(
    physics: Physics, scene: SceneArrays, control: Control, action: NDArray[np.float64]
) -> bool:
    """Goal at the first substep, torques at every one; False when the physics diverges."""
    for substep in range(SUBSTEPS):
        if not (_finite(physics.qvel, LARGEST) and _finite(physics.qpos, LARGEST)):
            return False
        mj_step1(physics.model, physics.data)
        if substep == 0:
            set_goal(physics, scene, control, action)
            _advance_gripper(physics, scene, control, action[action.shape[0] - 1])
        set_torques(physics, scene, control)
        mj_step2(physics.model, physics.data)
    return _finite(physics.qvel, LARGEST) and _finite(physics.qpos, LARGEST)


@compiled
def _advance_gripper(physics: Physics, scene: SceneArrays, control: Control, action: float) -> None:
    """Integrate the gripper's command towards the action's sign and set its actuators."""
    step = scene.finger_speed if action > 0.0 else (-scene.finger_speed if action < 0.0 else 0.0)
    control.gripper[0] = min(max(control.gripper[0] + step, -1.0), 1.0)
    joints = control.posture.shape[0]
    for i in range(scene.close_signs.shape[0]):
        low, high = scene.ctrl_range[joints + i, 0], scene.ctrl_range[joints + i, 1]
        target = scene.close_signs[i] * control.gripper[0]
        physics.ctrl[joints + i] = 0.5 * (high + low) + 0.5 * (high - low) * target


@compiled
def _finite(values: NDArray[np.float64], bound: float) -> bool:
    within = True
    for i in range(values.shape[0]):
        within &= abs(values[i]) < bound  # false for NaN too
    return within
