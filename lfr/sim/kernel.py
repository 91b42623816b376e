"""A run of control steps in one compiled call, with the GIL released.

One compiled specialisation serves every robot and task: what differs is data (`SceneArrays`).
"""

import math

import numpy as np
from numpy.typing import NDArray

from lfr.sim.compilation import compiled
from lfr.sim.cube import resize
from lfr.sim.engine import Engine
from lfr.sim.libmujoco import Physics, mj_kinematics, mj_resetData, mj_step1, mj_step2
from lfr.sim.observation import observe
from lfr.sim.osc import JOINTS, Controller, advance_gripper, set_goal, set_torques
from lfr.sim.rewards import reward_and_success
from lfr.sim.scene import SceneArrays
from lfr.sim.start import draw

SUBSTEPS = 25
"""Physics steps of 2 ms in a control step of 50 ms."""

LARGEST = 1e3
"""Beyond this position (rad, m) or velocity (per s) the physics counts as diverged."""


@compiled
def reset(engine: Engine, seed: int, observation: NDArray[np.float64]) -> None:
    """Start the episode that `seed` names; fill the observation (D,)."""
    physics, control, start, drawn = engine.physics, engine.control, engine.start, engine.drawn
    draw(start, seed, drawn)
    if start.sized:
        resize(engine.cube, drawn.cube_size)
    mj_resetData(physics.model, physics.data)
    for j in range(JOINTS):
        physics.qpos[j] = control.posture[j] = drawn.joint_position[j]
    # robosuite writes the open position in the order of the gripper's joints.
    physics.qpos[JOINTS], physics.qpos[JOINTS + 1] = start.open_fingers[0], start.open_fingers[1]
    for i in range(start.addresses.shape[0]):
        address = start.addresses[i]
        if address >= 0:
            for k in range(7):
                physics.qpos[address + k] = drawn.poses[i, k]
    control.gripper[0] = 0.0
    current(engine, observation)


@compiled
def current(engine: Engine, observation: NDArray[np.float64]) -> None:
    """Bring the kinematics up to date; fill the observation (D,)."""
    mj_kinematics(engine.physics.model, engine.physics.data)
    observe(engine.physics, engine.scene, engine.control, observation)


@compiled
def run(
    engine: Engine,
    actions: NDArray[np.float64],
    stop_on_success: bool,
    observations: NDArray[np.float64],
    rewards: NDArray[np.float64],
    successes: NDArray[np.bool_],
) -> tuple[int, bool]:
    """Apply actions (H, 7); fill observations (H, D), rewards (H,), successes (H,).

    Returns:
        The number of steps taken, and whether the last of them diverged; the observation of a
        diverged step repeats the last finite one.
    """
    physics, scene, control = engine.physics, engine.scene, engine.control
    last = actions.shape[0]
    for t in range(last):
        if not _finite(actions[t], math.inf) or not _control_step(
            physics, scene, control, actions[t]
        ):
            if t > 0:
                observations[t] = observations[t - 1]
            rewards[t], successes[t] = 0.0, False
            return t + 1, True
        rewards[t], successes[t] = reward_and_success(physics, scene)
        mj_kinematics(physics.model, physics.data)
        observe(physics, scene, control, observations[t])
        if stop_on_success and successes[t]:
            return t + 1, False
    return last, False


@compiled
def _control_step(
    physics: Physics, scene: SceneArrays, control: Controller, action: NDArray[np.float64]
) -> bool:
    """Goal at the first substep, torques at every one; False when the physics diverges."""
    for substep in range(SUBSTEPS):
        if not (_finite(physics.qvel, LARGEST) and _finite(physics.qpos, LARGEST)):
            return False
        mj_step1(physics.model, physics.data)
        if substep == 0:
            set_goal(physics, scene, control, action)
            advance_gripper(physics, scene, control, action[6])
        set_torques(physics, scene, control)
        mj_step2(physics.model, physics.data)
    return _finite(physics.qvel, LARGEST) and _finite(physics.qpos, LARGEST)


@compiled
def _finite(values: NDArray[np.float64], bound: float) -> bool:
    within = True
    for i in range(values.shape[0]):
        within &= abs(values[i]) < bound  # false for NaN too
    return within
