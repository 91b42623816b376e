"""The tasks on stock robosuite: the oracle of the compiled engine, and the second judge."""

import logging
import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import lfr.tasks
from lfr.compiled import observation
from lfr.controllers.controller import CONTROL_FREQUENCY, Configuration
from lfr.embodiments import embodiment as embodiment_named
from lfr.robots import Robot
from lfr.sim.pads import pad_gap
from lfr.sim.steps import Steps
from lfr.sim.stock_grippers import mend_gripper
from lfr.tasks.task import EEF, Place, Term


def make_stock_environment(
    embodiment: str, task: str, *, hard_reset: bool, object_observation: bool = False
) -> Any:
    """robosuite's environment with its best switches for speed and without rendering."""
    # robosuite sets its logger's level when it is imported; a filter stays.
    logging.getLogger("robosuite_logs").addFilter(_errors_only)
    with warnings.catch_warnings():  # of its docstrings' backslashes, as often as it is compiled
        warnings.simplefilter("ignore", SyntaxWarning)
        import robosuite

    chosen, body = lfr.tasks.task(task), embodiment_named(embodiment)
    mend_gripper(body.gripper)
    return robosuite.make(
        chosen.stock_name,
        robots=body.robot.stock_name,
        gripper_types=body.gripper.stock_name,
        controller_configs=body.stock_config,
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
        use_object_obs=object_observation,
        renderer="mujoco",
        reward_shaping=True,
        control_freq=CONTROL_FREQUENCY,
        ignore_done=True,
        hard_reset=hard_reset,
        seed=0,
        **chosen.stock_options,
    )


def repaired_xml(environment: Any, robot: Robot) -> str:
    """robosuite's MJCF of an environment, with what is broken in it mended."""
    return robot.repaired(environment.edit_model_xml(environment.model.get_xml()))


def _errors_only(record: logging.LogRecord) -> bool:
    return record.levelno >= logging.ERROR


class StockSimulation:
    """One arm in one task on stock robosuite 1.5.2, observed as this project observes it.

    Two departures from stock: what is broken in robosuite's models is mended (`lfr.robots.repair`,
    `lfr.sim.stock_grippers`), and the controller is told to read the state afresh after a reset,
    where stock would use a stale mass matrix during the first substep.

    Observations are taken from the joint positions after a step. Stock's own observables, its
    reward and its success check lag them by one substep of 2 ms; reward and success are stock's.

    Args:
        embodiment, task: names.
        object_observation: have robosuite observe the objects too; nothing here reads it.

    Raises:
        UnknownNameError: unknown embodiment or task.
    """

    def __init__(self, embodiment: str, task: str, *, object_observation: bool = False) -> None:
        self.embodiment = embodiment_named(embodiment)
        self.robot = self.embodiment.robot
        self.task = lfr.tasks.task(task)
        self.layout = self.task.observation
        self.horizon = self.task.horizon
        # robosuite draws a size only when it builds the model anew.
        self._env = make_stock_environment(
            embodiment,
            task,
            hard_reset=self.task.sized is not None,
            object_observation=object_observation,
        )
        self._env._xml_processors.append(self.robot.repaired)
        # The first soft reset would still use the model built without the repairs.
        self._env._load_model()
        self._env._initialize_sim()
        self.reset(0)

    @property
    def _model(self) -> Any:
        return self._env.sim.model._model

    @property
    def _data(self) -> Any:
        return self._env.sim.data._data

    @property
    def _arm(self) -> Any:
        return self._env.robots[0]

    def reset(self, seed: int) -> NDArray[np.float64]:
        """Start an episode that `seed` fully determines; returns the observation (D,)."""
        # One generator is shared with the placement samplers, so its state is set in place.
        self._env.rng.bit_generator.state = np.random.default_rng(seed).bit_generator.state
        self._env.reset()
        self._arm.part_controllers["right"].new_update = True
        return self.observation()

    def step(self, actions: ArrayLike, stop_on_success: bool = False) -> Steps:
        """Apply `actions` (H, A) one control step each; stop early at success if asked to."""
        observations, rewards, successes = [], [], []
        diverged, size = False, self.embodiment.action.size
        for action in np.asarray(actions, dtype=np.float64).reshape(-1, size):
            _, reward, _, _ = self._env.step(action)
            rewards.append(float(reward))
            successes.append(bool(self._env._check_success()))
            observations.append(self.observation())
            diverged = not bool(np.isfinite(observations[-1]).all())
            if diverged or (stop_on_success and successes[-1]):
                break
        return Steps(
            np.array(observations, dtype=np.float64).reshape(-1, self.layout.size),
            np.array(rewards, dtype=np.float64),
            np.array(successes, dtype=np.bool_),
            diverged,
        )

    def observation(self) -> NDArray[np.float64]:
        """The current observation (D,), in the base frame; see `lfr.tasks.Task.observation`."""
        import mujoco

        mujoco.mj_kinematics(self._model, self._data)
        return np.concatenate([self._state(), self._environment_state()])

    def joint_position(self) -> NDArray[np.float64]:
        """(N,) rad."""
        return np.array([self._data.joint(name).qpos[0] for name in self.robot.joints])

    def joint_velocity(self) -> NDArray[np.float64]:
        """(N,) rad/s."""
        return np.array([self._data.joint(name).qvel[0] for name in self.robot.joints])

    def configuration(self) -> Configuration:
        """Where the arm stands, for `Controller.action_of`."""
        import mujoco

        model, data, robot = self._model, self._data, self.robot
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        world = np.zeros((6, model.nv))
        mujoco.mj_jacSite(model, data, world[:3], world[3:], data.site(robot.gripper.grip_site).id)
        _, axes = self._base()
        dofs = [int(model.joint(name).dofadr[0]) for name in robot.joints]
        jacobian = np.vstack([axes.T @ world[:3, dofs], axes.T @ world[3:, dofs]])
        rest, scale = np.array(self._arm.init_qpos), np.array(self.embodiment.action_scale)
        return Configuration(self.joint_position(), rest, jacobian, scale)

    def body_poses(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Body name -> position (3,) m and quaternion (4,) wxyz, in the world frame."""
        bodies = (self._data.body(i) for i in range(1, self._model.nbody))
        return {body.name: (body.xpos.copy(), body.xquat.copy()) for body in bodies}

    def state(self) -> NDArray[np.float64]:
        """(S,): physics, null-space target, gripper command and the manipulated geom's size."""
        size = self._model.geom_size[self._first_geom()]
        target = self._arm.part_controllers["right"].initial_joint
        data = self._data
        return np.concatenate(
            [data.qpos, data.qvel, data.qacc_warmstart, target, [self._gripper_command()], size]
        )

    def set_state(self, state: ArrayLike) -> None:
        """Continue exactly from a `state()` of the same robot, task and cube size."""
        import mujoco

        data, nq, nv = self._data, self._model.nq, self._model.nv
        lengths = [nq, nv, nv, len(self.robot.joints), 1]
        parts = np.split(np.asarray(state, dtype=np.float64), np.cumsum(lengths))
        data.qpos[:], data.qvel[:] = parts[0], parts[1]
        mujoco.mj_forward(self._model, data)
        data.qacc_warmstart[:] = parts[2]
        controller = self._arm.part_controllers["right"]
        controller.initial_joint = parts[3].copy()
        controller.new_update = True
        self._arm.gripper["right"].current_action = parts[4] * np.array(
            self.robot.gripper.close_signs
        )
        self._model.geom_size[self._first_geom()] = parts[5]

    def _first_geom(self) -> int:
        body = next(iter(self.task.objects.values()))
        return int(self._model.body(body).geomadr[0])

    def _gripper_command(self) -> float:
        command = np.asarray(self._arm.gripper["right"].current_action, dtype=np.float64)
        return (
            float(
                np.broadcast_to(command, len(self.robot.gripper.close_signs))[0]
                * self.robot.gripper.close_signs[0]
            )
            + 0.0
        )

    def _base(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        body = self._data.body(self.robot.base_body)
        return body.xpos, body.xmat.reshape(3, 3)

    def _eef(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        origin, axes = self._base()
        site = self._data.site(self.robot.gripper.grip_site)
        return axes.T @ (site.xpos - origin), axes.T @ site.xmat.reshape(3, 3)

    def _state(self) -> NDArray[np.float64]:
        position, rotation = self._eef()
        rot6d = rotation[:, :2].T.ravel()
        aperture = pad_gap(self._model, self._data, self.robot.gripper)
        return np.concatenate([position, rot6d, [aperture, self._gripper_command()]])

    def _environment_state(self) -> NDArray[np.float64]:
        return np.concatenate([self._term(term) for term in self.task.terms])

    def _term(self, term: Term) -> NDArray[np.float64]:
        position, axes = self._place(term.to)
        if term.kind == observation.POSITION:
            return position
        if term.kind == observation.AXIS:
            return axes[:, 2]
        origin, reference = self._place(term.origin)
        if term.kind == observation.DISPLACEMENT:
            return position - origin
        return _yaw(axes, reference, term.quantity.fold)

    def _place(self, place: Place) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Position (3,) and rotation matrix (3, 3) in the base frame."""
        if place == EEF:
            return self._eef()
        origin, axes = self._base()
        if place.kind == "point":
            return axes.T @ (self.task.points(self._env)[place.name] - origin), np.eye(3)
        found = (self._data.body if place.kind == "body" else self._data.site)(place.name)
        return axes.T @ (found.xpos - origin), axes.T @ found.xmat.reshape(3, 3)


def _yaw(
    axes: NDArray[np.float64], reference: NDArray[np.float64], symmetry: int
) -> NDArray[np.float64]:
    """cos and sin of k (psi - psi_reference), psi the yaw of the x axis, k the symmetry."""
    psi, psi_reference = (np.arctan2(matrix[1, 0], matrix[0, 0]) for matrix in (axes, reference))
    angle = symmetry * (psi - psi_reference)
    return np.array([np.cos(angle), np.sin(angle)])
