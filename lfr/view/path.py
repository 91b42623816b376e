"""The end effector's way through the world."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ACTION, STATE, Episode
from lfr.embodiments import embodiment, is_known
from lfr.spaces import position
from lfr.view.action import GRIPPER, own_action
from lfr.view.motion import Poses
from lfr.view.series import CLOSING_COLOR, OPEN_COLOR, TEAL

if TYPE_CHECKING:
    import rerun as rr

HAND = "gripper0_right_eef"
"""The body whose origin is the grip site, on every arm of `lfr.robots`."""

EEF_POS = position("eef").names  # in the base frame
STEM = re.compile(r"((robot\d*_)?(eef|ee|tcp|end_effector)(_pos|_position|_xyz)?[._])?")
"""What may stand before x, y and z where these are the end effector's, in lower case."""


def end_effector_path(episode: Episode, poses: Poses) -> NDArray[np.float64] | None:
    """The end effector's positions (T, 3) (m), or None where they are not known.

    In the world where the base's pose is known. Without any poses they are in the frame of the
    episode's own state, whose names say which of its dimensions they are (`STEM`).
    """
    names = _state_names(episode)
    known = is_known(episode.robot)
    base = poses.get(embodiment(episode.robot).robot.base_body) if known else None
    if base is not None and names[:3] == EEF_POS:
        return base[0, :3] + episode.features[STATE][:, :3] @ _rotation(base[0, 3:]).T
    if HAND in poses:  # what frame the state's own positions are in, nothing says
        return np.asarray(poses[HAND][: len(episode), :3], np.float64)
    places = end_effector_dimensions(names)
    if places is None:
        return None
    return np.asarray(episode.features[STATE], np.float64)[:, places]


def end_effector_dimensions(names: Sequence[str]) -> list[int] | None:
    """Which of a state's dimensions are x, y and z of the end effector; None where none are.

    Such as `eef_pos.x`, `robot0_eef_pos.y`, `ee.z`, `tcp_x`, or `x`, `y` and `z` alone.
    """
    place = {name.lower(): index for index, name in enumerate(names)}
    stems = [name[:-1] for name in place if name.endswith("x") and STEM.fullmatch(name[:-1])]
    for stem in sorted(stems, key=len, reverse=True):  # what names the end effector comes first
        axes = [f"{stem}{axis}" for axis in "xyz"]
        if all(axis in place for axis in axes):
            return [place[axis] for axis in axes]
    return None


def log_path(recording: rr.RecordingStream, episode: Episode, poses: Poses) -> None:
    """Log the end effector's way, coloured by what the gripper is told to do, if that is known."""
    import rerun as rr

    path = end_effector_path(episode, poses)
    if path is None:
        return
    width = rr.Radius.ui_points(1.5)
    action = own_action(episode)
    if action is None:
        line = rr.LineStrips3D([path], colors=[TEAL], radii=width)
        recording.log("/path/end_effector", line, static=True)
        return
    closing = episode.features[ACTION][:, action.index(GRIPPER)] > 0
    parts = (("open", ~closing, OPEN_COLOR), ("closing", closing, CLOSING_COLOR))
    for name, held, color in parts:
        strips = [path[start : end + 1] for start, end in _runs(held)]
        line = rr.LineStrips3D(strips, colors=[color] * len(strips), radii=width)
        recording.log(f"/path/gripper_{name}", line, static=True)


def _state_names(episode: Episode) -> tuple[str, ...]:
    return (episode.schema[STATE].names or ()) if STATE in episode.features else ()


def _runs(held: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last-plus-one index of every stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) of a unit quaternion wxyz."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
