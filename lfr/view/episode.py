"""An episode as a rerun recording: the arm in 3-D, its path, its cameras and its series over time.

Entities, on the timelines `time` (s) and `frame`:

    /world/<body>           Transform3D        pose in the world; geometry below it (lfr.view.scene)
    /path/gripper_open, /path/gripper_closing  LineStrips3D, where the end effector goes
    /camera/<name>          EncodedImage       JPEG
    /action/translation, /action/rotation, /action/gripper
    /gripper, /reward       Scalars, every series named
    /state/gripper, /state/success             StateChange
    /observation/<group>    Scalars            each group of the observation, such as cube_pos
    /joints                 Scalars            rad
    /about                  TextDocument       what the log says of itself
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import write_whole
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
from lfr.view.blueprint import EpisodeLayout, episode_blueprint
from lfr.view.eye import eye_on
from lfr.view.motion import Poses, poses_of
from lfr.view.scene import WORLD, body_path, log_scene, moving_bodies
from lfr.view.series import frame_times, log_series, log_states

if TYPE_CHECKING:
    import rerun as rr

APERTURE_SCALE = 0.08
"""m; the common scale of both arms' apertures (field notes, part 7)."""

OPEN_COLOR, CLOSING_COLOR = series.BLUE, series.AMBER
FAILURE, SUCCESSFUL = (90, 94, 102), series.GREEN


def episode_title(episode: Episode, note: str | None = None) -> str:
    """For people: `panda · lift · seed 3 · success`, after a note if there is one.

    The note stands first, since rerun's list of recordings shows some fifteen letters.
    """
    outcome = "success" if episode.success else "failure"
    title = f"{episode.robot} · {episode.task} · seed {episode.seed} · {outcome}"
    return f"{note} · {title}" if note else title


def save_episode(path: Path, episode: Episode, poses: Poses | None = None) -> None:
    """Write an episode and its blueprint to an `.rrd` file, whole."""
    import rerun as rr

    poses = poses_of(episode) if poses is None else poses
    layout = episode_layout(episode, poses)
    # rerun keeps one layout an application: each title is one, or recordings that are opened
    # together would all be laid out as the last of them.
    with write_whole(path) as partial, rr.RecordingStream(layout.title) as recording:
        recording.save(partial, default_blueprint=episode_blueprint(layout))
        log_episode(recording, episode, poses, layout.title)
        recording.flush()
        recording.disconnect()


def episode_layout(episode: Episode, poses: Poses, note: str | None = None) -> EpisodeLayout:
    """What the layout of an episode depends on; `note` stands before its title."""
    seen = [poses[b][:, :3] for b in moving_bodies(episode.robot, episode.task) if b in poses]
    keys = [key for key in (STATE, ENVIRONMENT_STATE) if key in episode.schema]
    names = [name for key in keys for name in episode.schema[key].names or ()]
    return EpisodeLayout(
        title=episode_title(episode, note),
        cameras=tuple(episode.images),
        groups={group: observation_title(group) for group in observation_groups(names)},
        eye=eye_on(np.concatenate(seen)),
    )


def log_episode(
    recording: rr.RecordingStream,
    episode: Episode,
    poses: Poses | None = None,
    title: str | None = None,
) -> None:
    """Log everything there is of an episode.

    Args:
        recording: where to log to.
        episode: T frames.
        poses: of the bodies (`lfr.view.motion`), found out from the episode by default.
        title: of the recording.

    Raises:
        DataError: the poses cannot be known from what the episode holds.
        UnknownNameError: a robot or task that this project does not know.
    """
    title = episode_title(episode) if title is None else title
    recording.send_recording_name(title)
    poses = poses_of(episode) if poses is None else poses
    moving = log_scene(recording, episode.robot, episode.task)
    log_poses(recording, {body: poses[body] for body in moving if body in poses})
    log_cube_size(recording, episode)
    log_path(recording, episode, poses)
    log_cameras(recording, episode)
    log_features(recording, episode)
    log_about(recording, episode, title)


def log_poses(recording: rr.RecordingStream, poses: Poses, world: str = WORLD) -> None:
    """Log the poses (N, 7) of bodies, one row a frame; a single row holds for the whole episode."""
    import rerun as rr

    for body, rows in poses.items():
        columns = rr.Transform3D.columns(
            translation=rows[:, :3],
            quaternion=np.roll(rows[:, 3:], -1, axis=1),  # wxyz -> xyzw
        )
        times = frame_times(np.arange(len(rows)))
        recording.send_columns(body_path(body, world), indexes=times, columns=columns)


def log_cube_size(recording: rr.RecordingStream, episode: Episode, world: str = WORLD) -> None:
    """Give Lift's cube the size that this episode drew; the scene has that of another draw."""
    import rerun as rr

    if episode.task == "lift" and len(episode.simulator_state):
        size = episode.simulator_state[0, -3:]  # half size (m), last in the state
        cube = rr.Boxes3D.from_fields(half_sizes=[size])
        recording.log(f"{body_path('cube_main', world)}/box", cube, static=True)


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


def log_cameras(recording: rr.RecordingStream, episode: Episode) -> None:
    """Log the recorded JPEG images of every camera."""
    import rerun as rr

    for camera, files in episode.images.items():
        path = f"/camera/{camera}"
        recording.log(path, rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
        columns = rr.EncodedImage.columns(blob=list(files))
        recording.send_columns(path, indexes=frame_times(np.arange(len(files))), columns=columns)


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


def log_about(recording: rr.RecordingStream, episode: Episode, title: str) -> None:
    """Log what is known of the episode as a table to read."""
    import rerun as rr

    known = {
        "robot": episode.robot,
        "task": episode.task,
        "seed": episode.seed,
        "success": "yes" if episode.success else "no",
        "frames": len(episode),
        **{k: v for k, v in episode.metadata.items() if isinstance(v, str | int | float)},
    }
    rows = "\n".join(f"| {key} | {value} |" for key, value in known.items())
    text = f"# {title}\n\n| | |\n|---|---|\n{rows}\n"
    recording.log("/about", rr.TextDocument(text, media_type="text/markdown"), static=True)


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


def _runs(held: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last-plus-one index of every stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) of a unit quaternion wxyz."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
