"""An episode's features as named series: action, gripper, reward, success, observation, joints.

The action of a known embodiment is seen as the quantities of its space: translation and rotation,
or the joints; and the gripper. Of any other layout nothing is known but its names: its dimensions
are seen in the groups that these make.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lfr.data.episode import (
    ACTION,
    ENVIRONMENT_STATE,
    JOINT_POSITION,
    REWARD,
    STATE,
    SUCCESS,
    Episode,
)
from lfr.errors import UnknownNameError
from lfr.spaces import quantity
from lfr.view import action, series
from lfr.view.action import motion_title, own_action
from lfr.view.series import (
    CLOSING_COLOR,
    OPEN_COLOR,
    entity_part,
    fps_of,
    frame_times,
    log_series,
    log_states,
)

if TYPE_CHECKING:
    import rerun as rr

APERTURE_SCALE = 0.08
"""m; the common scale of all arms' apertures."""

GRIPPER = ("gripper_aperture", "gripper_command")  # of this project's state
OBSERVATION = "observation."
FAILURE, SUCCESSFUL = (90, 94, 102), series.GREEN


@dataclass(frozen=True)
class Group:
    """Dimensions of a feature that are seen together.

    Attributes:
        key: of the feature.
        title: for people, with the unit where the name tells it.
        indices: of the dimensions.
        parts: what each is called within the group.
    """

    key: str
    title: str
    indices: tuple[int, ...]
    parts: tuple[str, ...]


def log_features(recording: rr.RecordingStream, episode: Episode) -> None:
    """Log action, gripper, reward, success, observation and joints as named series."""
    features, schema = episode.features, episode.schema
    times = frame_times(np.arange(len(episode)), fps_of(episode))

    own = own_action(episode)
    if own is not None:
        closing = np.asarray(features[ACTION])[:, own.slice(action.GRIPPER)]
        log_series(recording, "/action/gripper", times, closing, ["action"], [series.AMBER])
        words = np.where(closing[:, 0] > 0, "close", "open")
        colors = {"open": OPEN_COLOR, "close": CLOSING_COLOR}
        log_states(recording, "/state/gripper", times, list(words), colors)
    if REWARD in features:
        log_series(recording, "/reward", times, features[REWARD], ["reward"], [series.VIOLET])
    if SUCCESS in features:
        words = np.where(features[SUCCESS], "success", "not yet")
        colors = {"not yet": FAILURE, "success": SUCCESSFUL}
        log_states(recording, "/state/success", times, list(words), colors)

    names = (schema[STATE].names or ()) if STATE in features else ()
    if set(GRIPPER) <= set(names):
        aperture, command = (features[STATE][:, names.index(name)] for name in GRIPPER)
        opening = np.stack([aperture / APERTURE_SCALE, command], axis=1)
        labels = [f"aperture (1 = {100 * APERTURE_SCALE:.0f} cm)", "integrated command"]
        log_series(recording, "/gripper", times, opening, labels, [series.TEAL, series.GREY])
    _log_groups(recording, "/action", times, episode, action_groups(episode))
    _log_groups(recording, "/observation", times, episode, observation_groups(episode))
    if JOINT_POSITION in features:
        joints = [name.removeprefix("robot0_") for name in schema[JOINT_POSITION].names or ()]
        log_series(recording, "/joints", times, features[JOINT_POSITION], joints)


def action_groups(episode: Episode) -> dict[str, Group]:
    """The groups of the action, the gripper of a known one aside, by entity below `/action`."""
    own = own_action(episode)
    if own is None:
        return _groups(ACTION, episode.schema[ACTION].names or (), {}, str)
    return {
        each.name: Group(ACTION, motion_title(each), tuple(range(*place.indices(own.size))),
                         each.parts)
        for each, place in own.items()
        if each.name != action.GRIPPER
    }  # fmt: skip


def observation_groups(episode: Episode) -> dict[str, Group]:
    """The groups of all that was observed, joints aside, by entity below `/observation`."""
    others = [
        key
        for key, values in episode.features.items()
        if key.startswith(OBSERVATION) and np.asarray(values).dtype.kind in "biuf"
    ]
    title = str if own_action(episode) is None else _titled  # others' names say no unit
    found: dict[str, Group] = {}
    for key in dict.fromkeys([STATE, ENVIRONMENT_STATE, *others]):
        if key in episode.features and key != JOINT_POSITION:
            found |= _groups(key, episode.schema[key].names or (), found, title)
    return found


def _groups(
    key: str, names: Sequence[str], taken: Mapping[str, Group], title: Callable[[str], str]
) -> dict[str, Group]:
    """Dimensions by the part of their name before the dot: `cube_pos.x` is one of `cube_pos`.

    They are all one group, called as the feature is, where that would leave each on its own.
    """
    stems: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        stems.setdefault(name.partition(".")[0], []).append(index)
    feature = key.rpartition(".")[2]
    if len(stems) == len(names) > 1:
        stems = {feature: list(range(len(names)))}
    found: dict[str, Group] = {}
    for stem, indices in stems.items():
        entity = entity_part(stem)
        while entity in taken or entity in found:
            entity = f"{entity_part(feature)}_{entity}"
        parts = [names[index].removeprefix(f"{stem}.") for index in indices]
        found[entity] = Group(key, title(stem), tuple(indices), tuple(parts))
    return found


def _titled(group: str) -> str:
    """A group with its unit, where the name says it."""
    try:
        unit = quantity(group).unit
    except UnknownNameError:
        unit = ""
    return f"{group} ({unit})" if unit else group


def _log_groups(
    recording: rr.RecordingStream,
    path: str,
    times: list[rr.TimeColumn],
    episode: Episode,
    groups: Mapping[str, Group],
) -> None:
    for entity, group in groups.items():
        values = np.asarray(episode.features[group.key], np.float64)
        table = values.reshape(len(values), -1)[:, group.indices]  # (T, dimensions)
        log_series(recording, f"{path}/{entity}", times, table, group.parts)
