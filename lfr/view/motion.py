"""Where every body is at every frame of an episode: from its log, states, observations or joints.

Poses are a dictionary from body to (N, 7): position x y z (m) and quaternion qw qx qy qz, in the
world frame; N is T + 1 where the pose after the last action is known, else T.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lfr.tasks
from lfr.data.episode import ENVIRONMENT_STATE, JOINT_POSITION, STATE, Episode
from lfr.embodiments import embodiment, is_known
from lfr.errors import DataError
from lfr.robots import Gripper, Robot
from lfr.spaces import ROBOT_STATE, Space
from lfr.tasks import TASKS

Poses = Mapping[str, NDArray[np.float64]]


def poses_of(episode: Episode, log: Path | None = None) -> Poses:
    """The best poses there are: of the log, of the simulator's states, or of the observations.

    Args:
        episode: the episode.
        log: the MCAP file that it came from, if it is at hand.

    Returns:
        The poses; of the arm alone, where its joints are all that is known; none of a robot that
        is not known here, or that says nothing of its joints.

    Raises:
        DataError: the log is damaged, or its states are of another simulation.
    """
    if log is not None:
        from lfr.data.log_reader import body_poses

        poses = body_poses(log)
        if poses:
            return poses
    if len(episode.simulator_state) and in_known_scene(episode):
        return poses_of_states(episode)
    if _observes_scene(episode):
        return poses_of_observations(episode)
    return poses_of_joints(episode) if _has_joints(episode) else {}


def in_known_scene(episode: Episode) -> bool:
    """Whether this project can build the scene that an episode happened in."""
    return is_known(episode.robot) and episode.task in TASKS


def poses_of_states(episode: Episode) -> Poses:
    """Poses (T + 1, 7) of an episode's simulator states, which begin with MuJoCo's `qpos`.

    Raises:
        DataError: states of another simulation than `lfr.sim.Simulation`.
    """
    import mujoco

    from lfr.view.scene import kinematic_model

    robot = _robot(episode)
    model = kinematic_model(robot.name, episode.task)
    data = mujoco.MjData(model)
    states = episode.simulator_state
    # qpos, qvel, warm start, posture, gripper command, cube size: lfr.sim.Simulation.state
    expected = model.nq + 2 * model.nv + len(robot.joints) + 1 + 3
    if states.shape[1] != expected:
        raise DataError(
            "simulator states of another simulation",
            file=str(episode.metadata.get("file", "episode")),
            column="simulator_state",
            found=states.shape[1],
            expected=expected,
        )
    rows = np.empty((len(states), model.nbody, 7))
    for row, state in zip(rows, states, strict=True):
        data.qpos[:] = state[: model.nq]
        mujoco.mj_kinematics(model, data)
        row[:, :3], row[:, 3:] = data.xpos, data.xquat
    return {model.body(b).name: rows[:, b] for b in range(1, model.nbody)}


def poses_of_observations(episode: Episode) -> Poses:
    """Poses (T, 7) from joint positions and object observations, through MuJoCo's kinematics.

    Nearly exact, and enough to look at: fingers are taken as symmetric, or at rest where their
    gap does not say where their joints are; objects with rotational symmetry are known up to it,
    and an object that is observed by its position alone (the lower cube of `stack`) stands upright.

    Raises:
        DataError: the episode has no joint positions.
    """
    import mujoco

    from lfr.view.scene import kinematic_model

    robot, task = _robot(episode), lfr.tasks.task(episode.task)
    for key in (STATE, ENVIRONMENT_STATE, JOINT_POSITION):
        if key not in episode.features:
            raise DataError(
                "the arm cannot be shown without this column",
                file=str(episode.metadata.get("file", "episode")),
                column=key,
                found="none",
                expected=key,
            )
    model = kinematic_model(robot.name, task.name)
    data = mujoco.MjData(model)
    state = np.asarray(episode.features[STATE], np.float64)
    observed = _quantities(task.environment, episode.features[ENVIRONMENT_STATE])
    joints = [model.joint(name).qposadr[0] for name in robot.joints]
    fingers, opening = _fingers(episode, robot.gripper, model)
    folds = {quantity.name: quantity.fold for quantity in task.environment.quantities}
    rows = []
    for t in range(len(episode)):
        data.qpos[joints] = episode.features[JOINT_POSITION][t]
        data.qpos[fingers] = opening[t]
        mujoco.mj_kinematics(model, data)
        base = data.body(robot.base_body)
        axes = base.xmat.reshape(3, 3)
        for name, body in task.objects.items():
            seen = {known: values[t] for known, values in observed.items()}
            local = _orientation(name, folds.get(f"{name}_yaw", 1), seen, state[t], model)
            start = model.joint(model.body(body).jntadr[0]).qposadr[0]
            data.qpos[start : start + 3] = base.xpos + axes @ observed[f"{name}_pos"][t]
            mujoco.mju_mat2Quat(data.qpos[start + 3 : start + 7], (axes @ local).ravel())
        mujoco.mj_kinematics(model, data)
        rows.append(np.hstack([data.xpos, data.xquat]))
    stacked = np.array(rows)  # (T, bodies, 7)
    return {model.body(b).name: stacked[:, b] for b in range(1, model.nbody)}


def poses_of_joints(episode: Episode) -> Poses:
    """Poses (T, 7) of an arm's bodies from its joint positions, through MuJoCo's kinematics.

    They are in the world of the episode's task. Where the task is not known here, the origin is the
    arm's base. The fingers stand as the state says (`FINGERS`), else as at MuJoCo's zero.

    Raises:
        UnknownNameError: no robot of that name.
    """
    import mujoco

    from lfr.view.scene import ANY_TASK, kinematic_model

    robot, known = _robot(episode), in_known_scene(episode)
    model = kinematic_model(robot.name, episode.task if known else ANY_TASK)
    data = mujoco.MjData(model)
    joints = [model.joint(name).qposadr[0] for name in robot.joints]
    fingers, opening = _fingers(episode, robot.gripper, model)
    base = model.body(robot.base_body).id
    arm = np.flatnonzero(model.body_rootid == model.body_rootid[base])
    rows = np.empty((len(episode), len(arm), 7))
    for t, row in enumerate(rows):
        data.qpos[joints] = episode.features[JOINT_POSITION][t]
        data.qpos[fingers] = opening[t]
        mujoco.mj_kinematics(model, data)
        row[:, :3], row[:, 3:] = data.xpos[arm], data.xquat[arm]
    if not known:
        rows[:, :, :3] -= data.xpos[base]  # robosuite moves an arm's base and does not turn it
    return {model.body(b).name: rows[:, i] for i, b in enumerate(arm)}


FINGERS = (("gripper_aperture",), ("robot0_gripper_qpos.0", "robot0_gripper_qpos.1"))
"""Names of the state's dimensions that say where the fingers are: this project's, robosuite's."""


def _robot(episode: Episode) -> Robot:
    """The arm of an episode. Raises UnknownNameError where there is none of that name."""
    return embodiment(episode.robot).robot


def _fingers(
    episode: Episode, gripper: Gripper, model: Any
) -> tuple[list[int], NDArray[np.float64]]:
    """Places (F,) in `qpos` and positions (T, F) of the finger joints that the state tells.

    They are told by the gap between the pads, or by robosuite's own names; F is 0 where the state
    has neither.
    """
    names = _names(episode, STATE)
    there = next((wanted for wanted in FINGERS if set(wanted) <= set(names)), ())
    if not there or len(there) not in (1, len(gripper.joints)):
        return [], np.zeros((len(episode), 0))
    fingers = [int(model.joint(joint).qposadr[0]) for joint in gripper.joints]
    places = [names.index(name) for name in there]
    found = np.asarray(episode.features[STATE], np.float64)[:, places]
    if len(there) > 1:
        return fingers, found
    return fingers, _fingers_at(found[:, 0], fingers, gripper, model)


def _fingers_at(
    gaps: NDArray[np.float64], fingers: list[int], gripper: Gripper, model: Any
) -> NDArray[np.float64]:
    """Finger joints (T, F), between closed and open, where the pads are ``gaps`` (T,) apart."""
    import mujoco

    from lfr.sim.pads import pad_gap

    data = mujoco.MjData(model)
    shares, known = np.linspace(0.0, 1.0, 33), []
    closed, opened = np.array(gripper.closed), np.array(gripper.opened)
    for share in shares:
        data.qpos[fingers] = closed + share * (opened - closed)
        mujoco.mj_kinematics(model, data)
        known.append(pad_gap(model, data, gripper))
    return closed + np.interp(gaps, known, shares)[:, None] * (opened - closed)


def _observes_scene(episode: Episode) -> bool:
    """Whether an episode's observations are those that this project makes of its scene."""
    if not (in_known_scene(episode) and _has_joints(episode)):
        return False
    environment = lfr.tasks.task(episode.task).environment.names
    names = _names(episode, STATE), _names(episode, ENVIRONMENT_STATE)
    return names == (ROBOT_STATE.names, environment)


def _has_joints(episode: Episode) -> bool:
    """Whether an arm that is known here says the angle of each of its joints."""
    if not is_known(episode.robot) or JOINT_POSITION not in episode.features:
        return False
    return episode.features[JOINT_POSITION].shape[1:] == (len(_robot(episode).joints),)


def _names(episode: Episode, key: str) -> tuple[str, ...]:
    return (episode.schema[key].names or ()) if key in episode.features else ()


def _quantities(space: Space, values: NDArray[Any]) -> dict[str, NDArray[np.float64]]:
    """The columns (T, d) of each quantity of (T, D) values, by its name."""
    table = np.asarray(values, np.float64)
    return {quantity.name: table[:, place] for quantity, place in space.items()}


def _orientation(
    name: str,
    fold: int,
    observed: dict[str, NDArray[np.float64]],
    state: NDArray[np.float64],
    model: Any,
) -> NDArray[np.float64]:
    """Rotation (3, 3) of an object in the base frame, its z axis and its yaw given.

    Args:
        fold: k of `<object>_yaw` = cos, sin(k (psi_object - psi_eef)).
    """
    up = observed.get(f"{name}_up", np.array([0.0, 0.0, 1.0]))
    yaw = 0.0
    if f"{name}_yaw" in observed:
        cos, sin = observed[f"{name}_yaw"]
        yaw = np.arctan2(state[4], state[3]) + np.arctan2(sin, cos) / fold
    rotation = _frame(up, yaw)
    if "eef_to_handle" in observed:  # half a turn is no symmetry of a nut with a handle
        handle = observed["eef_to_handle"] + state[:3] - observed[f"{name}_pos"]
        if (rotation @ model.site("SquareNut_handle_site").pos) @ handle < 0:
            rotation = _frame(up, yaw + np.pi)
    return rotation


def _frame(up: NDArray[np.float64], yaw: float) -> NDArray[np.float64]:
    """The frame whose z axis is `up` and whose x axis points to `yaw` seen from above."""
    z = up / np.linalg.norm(up)
    heading = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    if abs(z[2]) > 1e-3:
        heading[2] = -(heading @ z) / z[2]  # perpendicular to z, with the same yaw
    x = heading - (heading @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1).astype(np.float64)
