"""What a policy would have done at each recorded state, beside what was done.

Entities, on the timelines of `lfr.view.episode`:

    /action/<group>/policy   Scalars   as `/action/<group>`, of any policy in LeRobot's format

It is asked open loop: what is observed is what was recorded, wherever its own actions would have
led. A policy that carries out several actions at a time sees no more than it would have seen.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ACTION, IMAGES, Episode
from lfr.errors import LfrError
from lfr.lerobot_policy import LeRobotPolicy
from lfr.view import action, series
from lfr.view.action import own_action
from lfr.view.collection import EPISODE_ALONE, Overlay
from lfr.view.features import Group, action_groups
from lfr.view.series import Color, entity_part, fps_of, frame_times, log_series

if TYPE_CHECKING:
    import rerun as rr

    from lfr.view.motion import Poses


def policy_overlay(folder: Path, overlay: Overlay = EPISODE_ALONE) -> Overlay:
    """The actions of the policy in a folder, beside what another overlay shows.

    Raises:
        LfrError: there is no policy that LeRobot can load.
    """
    asked = LeRobotPolicy(folder)

    def log(recording: rr.RecordingStream, episode: Episode, poses: Poses) -> None:
        overlay.log(recording, episode, poses)
        _log_actions(recording, episode, _actions(asked, episode, folder))

    return replace(overlay, log=log)


def _actions(policy: LeRobotPolicy, episode: Episode, folder: Path) -> NDArray[np.float64]:
    """(T, A) at the recorded frames, one after the other."""
    task = str(episode.metadata.get("instruction") or episode.task)
    columns = {key: _column(episode, key, folder) for key in policy.columns}
    policy.reset()
    actions = np.array(
        [policy.act({key: values[frame] for key, values in columns.items()}, task)
         for frame in range(len(episode))]
    )  # fmt: skip
    recorded = np.asarray(episode.features[ACTION])
    recorded = recorded.reshape(len(recorded), -1)
    if actions.shape[1:] != recorded.shape[1:]:
        raise LfrError(
            f"--policy {folder} answers {actions.shape[1]} numbers, the episode's actions have "
            f"{recorded.shape[1]}"
        )
    return actions


def _column(episode: Episode, key: str, folder: Path) -> Any:
    """What is observed at each frame: numbers, or pictures (3, height, width) in [0, 1]."""
    if key in episode.features:
        values = np.asarray(episode.features[key])
        values = values.reshape(len(values), -1)
        return values.astype(np.float32) if values.dtype == np.float64 else values
    camera = entity_part(key.removeprefix(IMAGES).removeprefix("observation."))
    if camera in episode.images:
        return _Pictures(episode.images[camera])
    there = [one for one in episode.features if one.startswith("observation.")]
    raise LfrError(
        f"--policy {folder} sees {key}, which the episode has not; it has "
        f"{', '.join([*there, *(f'{IMAGES}{name}' for name in episode.images)])}"
    )


class _Pictures:
    """A camera's frames, decoded as they are asked for."""

    def __init__(self, files: Sequence[bytes]) -> None:
        self._files = files

    def __getitem__(self, frame: int) -> NDArray[np.float32]:
        from PIL import Image

        picture = np.asarray(Image.open(io.BytesIO(self._files[frame])).convert("RGB"))
        return np.moveaxis(picture, -1, 0).astype(np.float32) / 255.0


def _log_actions(
    recording: rr.RecordingStream, episode: Episode, actions: NDArray[np.float64]
) -> None:
    times = frame_times(np.arange(len(episode)), fps_of(episode))
    groups = dict(action_groups(episode))
    own = own_action(episode)
    if own is not None:
        place = own.slice(action.GRIPPER)
        indices = tuple(range(*place.indices(own.size)))
        groups["gripper"] = Group(ACTION, action.GRIPPER, indices, ("action",))
    for entity, group in groups.items():
        names = [f"{part}, policy" for part in group.parts]
        colors = [series.AMBER] if entity == "gripper" else series.PALETTE
        log_series(
            recording, f"/action/{entity}/policy", times, actions[:, group.indices], names,
            [_pale(color) for color in colors], width=1.0,
        )  # fmt: skip


def _pale(color: Color) -> Color:
    red, green, blue = (255 - (255 - part) // 2 for part in color)
    return red, green, blue
