"""An episode's features as named series: action, gripper, reward, success, observation, joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import (
    ACTION,
    ENVIRONMENT_STATE,
    JOINT_POSITION,
    REWARD,
    STATE,
    SUCCESS,
    Episode,
)
from lfr.view import series
from lfr.view.series import CLOSING_COLOR, OPEN_COLOR, frame_times, log_series, log_states

if TYPE_CHECKING:
    import rerun as rr

APERTURE_SCALE = 0.08
"""m; the common scale of both arms' apertures."""

FAILURE, SUCCESSFUL = (90, 94, 102), series.GREEN


def log_features(recording: rr.RecordingStream, episode: Episode) -> None:
    """Log action, gripper, reward, success, observation and joints as named series."""
    features, schema = episode.features, episode.schema
    times = frame_times(np.arange(len(episode)))

    action = np.asarray(features[ACTION])
    names = tuple(schema[ACTION].names or ()) or tuple(
        f"action_{k}" for k in range(action.shape[1])
    )
    log_series(recording, "/action/translation", times, action[:, :3], names[:3])
    log_series(recording, "/action/rotation", times, action[:, 3:-1], names[3:-1])
    log_series(recording, "/action/gripper", times, action[:, -1], ["action"], [series.AMBER])

    if REWARD in features:
        log_series(recording, "/reward", times, features[REWARD], ["reward"], [series.VIOLET])
    if SUCCESS in features:
        words = np.where(features[SUCCESS], "success", "not yet")
        colors = {"not yet": FAILURE, "success": SUCCESSFUL}
        log_states(recording, "/state/success", times, list(words), colors)
    words = np.where(action[:, -1] > 0, "close", "open")
    colors = {"open": OPEN_COLOR, "close": CLOSING_COLOR}
    log_states(recording, "/state/gripper", times, list(words), colors)

    state = features.get(STATE)
    if state is not None and state.shape[1] == 11:
        opening = np.stack([state[:, 9] / APERTURE_SCALE, state[:, 10]], axis=1)
        labels = [f"aperture (1 = {100 * APERTURE_SCALE:.0f} cm)", "integrated command"]
        log_series(recording, "/gripper", times, opening, labels, [series.TEAL, series.GREY])
    for key in (STATE, ENVIRONMENT_STATE):
        if key in features:
            _log_groups(recording, times, features[key], schema[key].names or ())
    if JOINT_POSITION in features:
        joints = [name.removeprefix("robot0_") for name in schema[JOINT_POSITION].names or ()]
        log_series(recording, "/joints", times, features[JOINT_POSITION], joints)


def observation_groups(names: Sequence[str]) -> dict[str, list[int]]:
    """Dimensions by the part of their name before the dot: `cube_pos` -> [0, 1, 2]."""
    groups: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        groups.setdefault(name.split(".")[0], []).append(index)
    return groups


def observation_title(group: str) -> str:
    """A group of the observation with its unit: positions, offsets and the aperture are lengths."""
    length = group.endswith(("_pos", "_aperture")) or "_to_" in group
    return f"{group} (m)" if length else group


def _log_groups(
    recording: rr.RecordingStream,
    times: list[rr.TimeColumn],
    values: NDArray[np.float32],
    names: Sequence[str],
) -> None:
    for group, indices in observation_groups(names).items():
        parts = [names[index].partition(".")[2] or group for index in indices]
        log_series(recording, f"/observation/{group}", times, values[:, indices], parts)
