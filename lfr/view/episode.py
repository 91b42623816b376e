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

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lfr.artifacts import write_whole
from lfr.data.episode import ENVIRONMENT_STATE, STATE, Episode
from lfr.view.blueprint import EpisodeLayout, episode_blueprint
from lfr.view.eye import eye_on
from lfr.view.features import log_features, observation_groups, observation_title
from lfr.view.motion import Poses, poses_of
from lfr.view.path import log_path
from lfr.view.scene import WORLD, body_path, log_scene, moving_bodies
from lfr.view.series import frame_times

if TYPE_CHECKING:
    import rerun as rr


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


def log_cameras(recording: rr.RecordingStream, episode: Episode) -> None:
    """Log the recorded JPEG images of every camera."""
    import rerun as rr

    for camera, files in episode.images.items():
        path = f"/camera/{camera}"
        recording.log(path, rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
        columns = rr.EncodedImage.columns(blob=list(files))
        recording.send_columns(path, indexes=frame_times(np.arange(len(files))), columns=columns)


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
