"""One arm in one task on the compiled engine."""

import copy
import functools
import logging
from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfr.sim import kernel, libmujoco, osc
from lfr.sim.compilation import compiling_once
from lfr.sim.layout import ObservationLayout, Steps
from lfr.sim.placement import Start
from lfr.sim.scene import Scene
from lfr.sim.scene_cache import load_scene

_LOG = logging.getLogger(__name__)


class Simulation:
    """One arm in one task, a whole run of control steps in one compiled call.

    Control is 20 Hz, physics 2 ms; observations, rewards and successes are those of
    `lfr.sim.stock.StockSimulation`, the oracle in the tests. `lfr.sim` lists what differs
    from stock robosuite. An instance is for one thread at a time; the GIL is released
    while it steps, so several instances run beside each other.

    Raises:
        UnknownNameError: unknown robot or task.
        LfrError: a libmujoco that the kernel was not checked against.
    """

    def __init__(self, robot: str, task: str) -> None:
        libmujoco.load()
        self._scene = scene = _scene(robot, task)
        self.robot, self.task = scene.robot, scene.task
        self.layout = ObservationLayout.of(scene.task)
        self.horizon = scene.task.horizon
        # Only Lift changes its model, by the size of its cube.
        self._resizable = scene.start.size_range is not None
        self._model = scene.model if not self._resizable else copy.copy(scene.model)
        self._data = mujoco.MjData(self._model)
        self._physics = libmujoco.physics(self._model, self._data)
        self._control = osc.controller()
        self._object_places = tuple(self._places())
        self._cube_size = np.zeros(3)
        with compiling_once():
            self.reset(0)

    def reset(self, seed: int) -> NDArray[np.float64]:
        """Start an episode that `seed` fully determines; returns the observation (D,).

        The start is the one that stock robosuite draws from the same seed.
        """
        start = self._scene.start.sample(seed)
        if start.cube_size is not None:
            self._resize_cube(start.cube_size)
        mujoco.mj_resetData(self._model, self._data)
        self._place(start)
        self._control.posture[:] = start.joint_position
        self._control.gripper[:] = 0.0
        return self.observation()

    def _place(self, start: Start) -> None:
        position = self._physics.qpos
        position[: osc.JOINTS] = start.joint_position
        # robosuite writes the open position in the order of the gripper's joints.
        position[osc.JOINTS : osc.JOINTS + 2] = self._scene.open_fingers
        for joint, place in self._object_places:
            position[place] = start.object_poses[joint]

    def _places(self) -> Iterator[tuple[str, slice]]:
        """Each observed object's free joint and where its pose stands in qpos."""
        for body in self.task.objects.values():
            joint = self._model.joint(int(self._model.body(body).jntadr[0]))
            address = int(joint.qposadr[0])
            yield joint.name, slice(address, address + 7)

    def step(self, actions: ArrayLike, stop_on_success: bool = False) -> Steps:
        """Apply `actions` (H, 7) one control step each; stop early at success if asked to.

        A step whose physics diverges, or whose action is not finite, ends the run with `diverged`;
        its observation repeats the last one, and the simulation is to be reset.
        """
        actions = np.ascontiguousarray(actions, dtype=np.float64).reshape(-1, 7)
        horizon = len(actions)
        observations = np.empty((horizon, self.layout.size))
        rewards, successes = np.empty(horizon), np.empty(horizon, dtype=np.bool_)
        if horizon == 0:
            return Steps(observations, rewards, successes)
        observations[0] = self._observation
        n, diverged = kernel.run(
            self._physics,
            self._scene.arrays,
            self._control,
            actions,
            stop_on_success,
            observations,
            rewards,
            successes,
        )
        self._observation = observations[n - 1]
        if diverged:
            _LOG.warning("%s-%s: the physics diverged", self.robot.name, self.task.name)
        return Steps(observations[:n], rewards[:n], successes[:n], bool(diverged))

    def observation(self) -> NDArray[np.float64]:
        """The current observation (D,), in the base frame; see `lfr.sim.layout`."""
        row, none = np.empty((1, self.layout.size)), np.empty((0, 7))
        arguments = (self._physics, self._scene.arrays, self._control, none, False)
        kernel.run(*arguments, row, np.empty(0), np.empty(0, dtype=np.bool_))
        self._observation = row[0]
        return row[0].copy()

    def position(self) -> NDArray[np.float64]:
        """(nq,): generalized positions of the arm, the fingers and the task's objects."""
        return self._data.qpos.copy()

    def joint_position(self) -> NDArray[np.float64]:
        """(7,) rad."""
        return self._data.qpos[: osc.JOINTS].copy()

    def joint_velocity(self) -> NDArray[np.float64]:
        """(7,) rad/s."""
        return self._data.qvel[: osc.JOINTS].copy()

    def body_poses(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Body name -> position (3,) m and quaternion (4,) wxyz, in the world frame."""
        bodies = (self._data.body(i) for i in range(1, self._model.nbody))
        return {body.name: (body.xpos.copy(), body.xquat.copy()) for body in bodies}

    def cube_size(self) -> NDArray[np.float64]:
        """(3,) m, half size of Lift's cube; zeros in the other tasks."""
        return self._cube_size.copy()

    def state(self) -> NDArray[np.float64]:
        """(S,): qpos, qvel, warm start, null-space target (7,), gripper command, cube size (3,)."""
        data, control = self._data, self._control
        parts = (data.qpos, data.qvel, data.qacc_warmstart, control.posture, control.gripper)
        return np.concatenate([*parts, self._cube_size])

    def set_state(self, state: ArrayLike) -> None:
        """Continue exactly from a `state()` of the same robot and task.

        Raises:
            ValueError: the state has another length.
        """
        model, data = self._model, self._data
        lengths = [model.nq, model.nv, model.nv, osc.JOINTS, 1, 3]
        state = np.asarray(state, dtype=np.float64)
        if state.shape != (sum(lengths),):
            raise ValueError(f"state has shape {state.shape}, expected ({sum(lengths)},)")
        parts = np.split(state, np.cumsum(lengths)[:-1])
        if self._resizable:
            self._resize_cube(parts[5])
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = parts[:3]
        self._control.posture[:], self._control.gripper[:] = parts[3:5]
        self.observation()

    def _resize_cube(self, size: NDArray[np.float64]) -> None:
        """Give Lift's cube other half sizes (m), as a compilation of the model with them would."""
        model, body = self._model, self._model.body(next(iter(self.task.objects.values())))
        geom, node = int(body.geomadr[0]), int(model.body_bvhadr[body.id])
        # From the scene's own model, so that nothing of an earlier cube enters.
        built = self._scene.model
        density = built.body_mass[body.id] / np.prod(built.geom_size[geom])
        mass = density * np.prod(size)
        model.geom_size[geom] = size
        model.geom_rbound[geom] = np.linalg.norm(size)
        model.geom_aabb[geom, 3:] = model.bvh_aabb[node, 3:] = size
        squares = size**2
        model.body_mass[body.id] = mass
        model.body_inertia[body.id] = mass / 3 * (squares.sum() - squares)
        mujoco.mj_setConst(model, self._data)
        self._cube_size[:] = size


@functools.cache
def simulation(robot: str, task: str) -> Simulation:
    """This process's one simulation of `robot` in `task`, for jobs that follow one another."""
    return Simulation(robot, task)


@functools.cache
def _scene(robot: str, task: str) -> Scene:
    return load_scene(robot, task)
