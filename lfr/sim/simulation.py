"""One arm in one task on the compiled engine."""

import functools
import logging

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfr.compiled import arrays
from lfr.controllers.controller import Configuration
from lfr.sim import kernel, libmujoco
from lfr.sim.compilation import compiling_once, make_callable
from lfr.sim.cube import ResizableModel, no_cube, resize
from lfr.sim.engine import engine
from lfr.sim.kinematics import jacobian
from lfr.sim.scene import Scene
from lfr.sim.scene_cache import load_scene
from lfr.sim.start import room
from lfr.sim.steps import Steps
from lfr.spaces import Space

_LOG = logging.getLogger(__name__)


class Simulation:
    """One embodiment in one task, a whole run of control steps in one compiled call.

    Control is 20 Hz, physics 2 ms; observations, rewards and successes are those of
    `lfr.sim.stock.StockSimulation`, the oracle in the tests. `lfr.sim` lists what differs
    from stock robosuite. An instance is for one thread at a time; the GIL is released
    while it steps, so several instances run beside each other.

    Raises:
        UnknownNameError: unknown embodiment or task.
        LfrError: a libmujoco that the kernel was not checked against.
    """

    def __init__(self, embodiment: str, task: str) -> None:
        libmujoco.load()
        self._scene = scene = _scene(embodiment, task)
        self.embodiment, self.task = scene.embodiment, scene.task
        self.robot = scene.embodiment.robot
        self.layout: Space = scene.task.observation
        self.joints, self.action_size = len(self.robot.joints), self.embodiment.action.size
        self.horizon = scene.task.horizon
        self._model, self._data = scene.model, mujoco.MjData(scene.model)
        sized = scene.task.sized  # it changes the model
        self._own = ResizableModel(self._model, sized.body) if sized else None
        address = None if self._own is None else self._own.address
        self._cube = no_cube() if self._own is None else self._own.cube
        self._physics = libmujoco.physics(self._model, self._data, address)
        self._control = arrays.control(self.joints)
        self._drawn = room(self.joints, len(scene.start.heights))
        self._observation = np.zeros(self.layout.size)
        make_callable()
        with compiling_once():
            self._engine = engine(
                self._physics, scene.arrays, self._control, scene.start, self._drawn, self._cube
            )
            self.reset(0)
            self.observation()
            self.step(np.empty((0, self.action_size)))

    def reset(self, seed: int) -> NDArray[np.float64]:
        """Start an episode that `seed` fully determines; returns the observation (D,).

        The start is the one that stock robosuite draws from the same seed.

        Raises:
            ValueError: a seed below 0, or not below 2^64.
        """
        if not 0 <= seed < 2**64:
            raise ValueError(f"seed {seed}, expected one from 0 to 2^64 - 1")
        kernel.reset(self._engine, np.uint64(seed), self._observation)  # type: ignore[arg-type]
        return self._observation.copy()

    def step(self, actions: ArrayLike, stop_on_success: bool = False) -> Steps:
        """Apply `actions` (H, A) one control step each; stop early at success if asked to.

        A step whose physics diverges, or whose action is not finite, ends the run with `diverged`;
        its observation repeats the last one, and the simulation is to be reset.
        """
        actions = np.ascontiguousarray(actions, dtype=np.float64).reshape(-1, self.action_size)
        horizon = len(actions)
        observations = np.empty((horizon, self.layout.size))
        rewards, successes = np.empty(horizon), np.empty(horizon, dtype=np.bool_)
        if horizon:
            observations[0] = self._observation
        n, diverged = kernel.run(
            self._engine,
            actions,
            stop_on_success,
            observations,
            rewards,
            successes,
        )
        if n:
            self._observation[:] = observations[n - 1]
        if diverged:
            _LOG.warning("%s-%s: the physics diverged", self.embodiment.name, self.task.name)
        return Steps(observations[:n], rewards[:n], successes[:n], bool(diverged))

    def observation(self) -> NDArray[np.float64]:
        """The current observation (D,), in the base frame; see `lfr.tasks.Task.observation`."""
        kernel.current(self._engine, self._observation)
        return self._observation.copy()

    def position(self) -> NDArray[np.float64]:
        """(nq,): generalized positions of the arm, the fingers and the task's objects."""
        return self._data.qpos.copy()

    def joint_position(self) -> NDArray[np.float64]:
        """(N,) rad."""
        return self._data.qpos[: self.joints].copy()

    def joint_velocity(self) -> NDArray[np.float64]:
        """(N,) rad/s."""
        return self._data.qvel[: self.joints].copy()

    def configuration(self) -> Configuration:
        """Where the arm stands, for `Controller.action_of`."""
        arrays, rest = self._scene.arrays, self._scene.start.joint_position
        J = jacobian(self._data, arrays, self.joints)
        return Configuration(self.joint_position(), rest, J, arrays.action_scale)

    def body_poses(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Body name -> position (3,) m and quaternion (4,) wxyz, in the world frame."""
        bodies = (self._data.body(i) for i in range(1, self._model.nbody))
        return {body.name: (body.xpos.copy(), body.xquat.copy()) for body in bodies}

    def cube_size(self) -> NDArray[np.float64]:
        """(3,) m, half size of Lift's cube; zeros in the other tasks."""
        return self._drawn.cube_size.copy()

    def state(self) -> NDArray[np.float64]:
        """(S,): qpos, qvel, warm start, starting posture (N,), gripper command, cube size (3,)."""
        data, control = self._data, self._control
        parts = (data.qpos, data.qvel, data.qacc_warmstart, control.posture, control.gripper)
        return np.concatenate([*parts, self._drawn.cube_size])

    def set_state(self, state: ArrayLike) -> None:
        """Continue exactly from a `state()` of the same embodiment and task.

        Raises:
            ValueError: the state has another length.
        """
        model, data = self._model, self._data
        lengths = [model.nq, model.nv, model.nv, self.joints, 1, 3]
        state = np.asarray(state, dtype=np.float64)
        if state.shape != (sum(lengths),):
            raise ValueError(f"state has shape {state.shape}, expected ({sum(lengths)},)")
        parts = np.split(state, np.cumsum(lengths)[:-1])
        self._drawn.cube_size[:] = parts[5]
        if self._own is not None:
            resize(self._cube, self._drawn.cube_size)
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = parts[:3]
        self._control.posture[:], self._control.gripper[:] = parts[3:5]
        self.observation()


@functools.cache
def simulation(embodiment: str, task: str) -> Simulation:
    """This process's one simulation of an embodiment in a task, for jobs that follow another."""
    return Simulation(embodiment, task)


@functools.cache
def _scene(embodiment: str, task: str) -> Scene:
    return load_scene(embodiment, task)
