"""Where every body is at every frame of an episode: from its log, its states or its observations.

Poses are a dictionary from body to (N, 7): position x y z (m) and quaternion qw qx qy qz, in the
world frame; N is T + 1 where the pose after the last action is known, else T.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ENVIRONMENT_STATE, JOINT_POSITION, STATE, Episode
from lfr.errors import DataError

Poses = Mapping[str, NDArray[np.float64]]


def poses_of(episode: Episode, log: Path | None = None) -> Poses:
    """The best poses there are: of the log, of the simulator's states, or of the observations.

    Args:
        episode: the episode.
        log: the MCAP file that it came from, if it is at hand.

    Raises:
        DataError: the log is damaged, or a column that the poses need is missing.
        UnknownNameError: the episode's robot or task is not known here.
    """
    if log is not None:
        from lfr.data.log_reader import body_poses

        poses = body_poses(log)
        if poses:
            return poses
    if len(episode.simulator_state):
        return poses_of_states(episode)
    return poses_of_observations(episode)


def poses_of_states(episode: Episode) -> Poses:
    """Poses (T + 1, 7) of an episode's simulator states, which begin with MuJoCo's `qpos`.

    Raises:
        DataError: states of another simulation than `lfr.sim.Simulation`.
    """
    import mujoco

    from lfr.view.scene import kinematic_model

    model = kinematic_model(episode.robot, episode.task)
    data = mujoco.MjData(model)
    states = episode.simulator_state
    # qpos, qvel, warm start, then posture (7), gripper command, cube size (3)
    expected = model.nq + 2 * model.nv + 11
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

    Nearly exact, and enough to look at: fingers are taken as symmetric, objects with rotational
    symmetry are known up to it, and an object that is observed by its position alone (the lower
    cube of `stack`) stands upright.

    Raises:
        DataError: the episode has no joint positions.
    """
    import mujoco

    import lfr.robots
    import lfr.tasks
    from lfr.view.scene import kinematic_model

    robot, task = lfr.robots.robot(episode.robot), lfr.tasks.task(episode.task)
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
    observed = _groups(task.environment, episode.features[ENVIRONMENT_STATE])
    joints = [model.joint(name).qposadr[0] for name in robot.joints]
    fingers = [model.joint(name).qposadr[0] for name in robot.finger_joints]
    opening = (state[:, 9] - robot.pad_gap_at_zero) / 2  # gap = first - second + gap at zero
    rows = []
    for t in range(len(episode)):
        data.qpos[joints] = episode.features[JOINT_POSITION][t]
        data.qpos[fingers] = opening[t], -opening[t]
        mujoco.mj_kinematics(model, data)
        base = data.body(robot.base_body)
        axes = base.xmat.reshape(3, 3)
        for name, body in task.objects.items():
            local = _orientation(name, {k: v[t] for k, v in observed.items()}, state[t], model)
            start = model.joint(model.body(body).jntadr[0]).qposadr[0]
            data.qpos[start : start + 3] = base.xpos + axes @ observed[f"{name}_pos"][t]
            mujoco.mju_mat2Quat(data.qpos[start + 3 : start + 7], (axes @ local).ravel())
        mujoco.mj_kinematics(model, data)
        rows.append(np.hstack([data.xpos, data.xquat]))
    stacked = np.array(rows)  # (T, bodies, 7)
    return {model.body(b).name: stacked[:, b] for b in range(1, model.nbody)}


def _groups(
    environment: tuple[tuple[str, tuple[str, ...]], ...], values: NDArray[Any]
) -> dict[str, NDArray[np.float64]]:
    ends = np.cumsum([len(parts) for _, parts in environment])
    split = np.split(np.asarray(values, np.float64), ends[:-1], axis=1)
    return {name: part for (name, _), part in zip(environment, split, strict=True)}


SYMMETRY = {"nut": 2}
"""k of `<object>_yaw` = cos, sin(k (psi_object - psi_eef)); a cube's is 4."""


def _orientation(
    name: str, observed: dict[str, NDArray[np.float64]], state: NDArray[np.float64], model: Any
) -> NDArray[np.float64]:
    """Rotation (3, 3) of an object in the base frame, its z axis and its yaw given."""
    up = observed.get(f"{name}_up", np.array([0.0, 0.0, 1.0]))
    yaw = 0.0
    if f"{name}_yaw" in observed:
        cos, sin = observed[f"{name}_yaw"]
        yaw = np.arctan2(state[4], state[3]) + np.arctan2(sin, cos) / SYMMETRY.get(name, 4)
    rotation = _frame(up, yaw)
    if "handle_to_eef" in observed:  # half a turn is no symmetry of a nut with a handle
        handle = observed["handle_to_eef"] + state[:3] - observed[f"{name}_pos"]
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
