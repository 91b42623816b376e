"""The end effector's way through the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ACTION, STATE, Episode
from lfr.view.motion import Poses
from lfr.view.series import CLOSING_COLOR, OPEN_COLOR

if TYPE_CHECKING:
    import rerun as rr


def end_effector_path(episode: Episode, poses: Poses) -> NDArray[np.float64] | None:
    """The end effector's positions (T, 3) in the world (m), or None where they are not known."""
    import lfr.robots

    base = poses.get(lfr.robots.robot(episode.robot).base_body)
    if STATE not in episode.features or base is None:
        return None
    return base[0, :3] + episode.features[STATE][:, :3] @ _rotation(base[0, 3:]).T


def log_path(recording: rr.RecordingStream, episode: Episode, poses: Poses) -> None:
    """Log the end effector's way through the world, coloured by what the gripper is told to do."""
    import rerun as rr

    path = end_effector_path(episode, poses)
    if path is None:
        return
    closing = episode.features[ACTION][:, -1] > 0
    parts = (("open", ~closing, OPEN_COLOR), ("closing", closing, CLOSING_COLOR))
    for name, held, color in parts:
        strips = [path[start : end + 1] for start, end in _runs(held)]
        line = rr.LineStrips3D(strips, colors=[color] * len(strips), radii=rr.Radius.ui_points(1.5))
        recording.log(f"/path/gripper_{name}", line, static=True)


def _runs(held: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last-plus-one index of every stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) of a unit quaternion wxyz."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
