"""An episode as a rerun recording: the arm in 3-D, its path, its cameras and its series over time.

Entities, on the timelines `time` (s) and `frame`:

    /world/<body>           Transform3D        pose in the world; geometry below it (lfr.view.scene)
    /path/gripper_open, /path/gripper_closing  LineStrips3D, where the end effector goes;
    /path/end_effector      where the action is no known embodiment's
    /camera/<name>          EncodedImage       JPEG
    /frustum/<name>         Transform3D, Pinhole, of what each camera of a log sees
    /action/translation, /action/rotation or /action/dq; /action/gripper
    /action/<group>         Scalars            of another layout
    /gripper, /reward       Scalars, every series named
    /state/gripper, /state/success             StateChange
    /observation/<group>    Scalars            each group of the observation, such as cube_pos
    /joints                 Scalars            rad
    /about                  TextDocument       what the log says of itself

What an episode does not have is left out: a robot that is not known here has no geometry, and an
end effector whose position is not recognised no path.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import write_whole
from lfr.data.episode import FPS, JOINT_POSITION, REWARD, SUCCESS, Episode
from lfr.embodiments import is_known
from lfr.tasks import TASKS
from lfr.view.action import own_action
from lfr.view.blueprint import EpisodeLayout, episode_blueprint
from lfr.view.eye import eye_on
from lfr.view.features import action_groups, log_features, observation_groups
from lfr.view.motion import Poses, in_known_scene, poses_of
from lfr.view.path import end_effector_path, log_path
from lfr.view.scene import WORLD, body_path, log_arm, log_scene, moving_bodies
from lfr.view.series import fps_of, frame_times

if TYPE_CHECKING:
    import rerun as rr

FRUSTUM = "/frustum"
DEPTH = 0.08
"""m, how far a frustum is drawn."""

UNSAID = "unsaid"
"""Key of an episode's metadata: which of `seed` and `success` the data does not say."""


def episode_title(episode: Episode, note: str | None = None) -> str:
    """For people: `panda · lift · seed 3 · success`, after a note if there is one.

    The note stands first, since rerun's list of recordings shows some fifteen letters.
    """
    words = [note, *scene_words(episode), seed_of(episode), outcome_of(episode)]
    return " · ".join(word for word in words if word) or "episode"


def scene_words(episode: Episode) -> list[str]:
    """The robot and the task, by its instruction where it has no name; what is known of them."""
    task = episode.task or str(episode.metadata.get("instruction") or "")
    return [word for word in (episode.robot, task) if word]


def seed_of(episode: Episode) -> str | None:
    """`seed 3`, or None where the data does not say."""
    return None if "seed" in episode.metadata.get(UNSAID, ()) else f"seed {episode.seed}"


def outcome_of(episode: Episode) -> str | None:
    """`success`, `failure`, or None where the data does not say."""
    if "success" in episode.metadata.get(UNSAID, ()):
        return None
    return "success" if episode.success else "failure"


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
    seen, there = places_seen(episode, poses), episode.features
    own = own_action(episode) is not None
    has = {
        "/state": SUCCESS in there or own,
        "/reward": REWARD in there,
        "/joints": JOINT_POSITION in there,
    }
    return EpisodeLayout(
        title=episode_title(episode, note),
        cameras=tuple(episode.images),
        groups={name: group.title for name, group in observation_groups(episode).items()},
        eye=eye_on(seen) if len(seen) else None,
        actions={name: group.title for name, group in action_groups(episode).items()},
        gripper=own,
        absent=frozenset(entity for entity, is_there in has.items() if not is_there),
    )


def places_seen(episode: Episode, poses: Poses) -> NDArray[np.float64]:
    """Where the 3-D view has something that moves, (N, 3) (m); N is 0 where there is nothing."""
    if poses and is_known(episode.robot):
        scene = moving_bodies(episode.robot, episode.task) if in_known_scene(episode) else poses
        seen = [poses[body][:, :3] for body in scene if body in poses]
        if seen:
            return np.concatenate(seen)
    path = end_effector_path(episode, poses)
    return np.zeros((0, 3)) if path is None else path[np.isfinite(path).all(axis=1)]


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
    """
    title = episode_title(episode) if title is None else title
    recording.send_recording_name(title)
    poses = poses_of(episode) if poses is None else poses
    log_bodies(recording, episode, poses)
    log_path(recording, episode, poses)
    log_cameras(recording, episode)
    log_frustums(recording, episode, poses)
    log_features(recording, episode)
    log_about(recording, episode, title)


def log_bodies(recording: rr.RecordingStream, episode: Episode, poses: Poses) -> None:
    """Log what can be seen of the bodies whose poses are known: the scene, or the arm alone."""
    import rerun as rr

    shown: tuple[str, ...] = ()
    if poses and in_known_scene(episode):
        shown = log_scene(recording, episode.robot, episode.task, placed=poses.keys())
        sized = TASKS[episode.task].sized
        if sized and sized.body in shown:
            log_size(recording, episode, sized.body)
    else:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        if poses and is_known(episode.robot):
            shown = log_arm(recording, episode.robot, poses.keys())
    log_poses(recording, {body: poses[body] for body in shown}, fps=fps_of(episode))


def log_poses(
    recording: rr.RecordingStream, poses: Poses, world: str = WORLD, fps: float = FPS
) -> None:
    """Log the poses (N, 7) of bodies, one row a frame; a single row holds for the whole episode."""
    import rerun as rr

    for body, rows in poses.items():
        columns = rr.Transform3D.columns(
            translation=rows[:, :3],
            quaternion=np.roll(rows[:, 3:], -1, axis=1),  # wxyz -> xyzw
        )
        times = frame_times(np.arange(len(rows)), fps)
        recording.send_columns(body_path(body, world), indexes=times, columns=columns)


def log_size(
    recording: rr.RecordingStream, episode: Episode, body: str, world: str = WORLD
) -> None:
    """Give a box the size that this episode drew; the scene has that of another draw."""
    import rerun as rr

    if len(episode.simulator_state):
        size = episode.simulator_state[0, -3:]  # half size (m), last in the state
        box = rr.Boxes3D.from_fields(half_sizes=[size])
        recording.log(f"{body_path(body, world)}/box", box, static=True)


def log_cameras(recording: rr.RecordingStream, episode: Episode) -> None:
    """Log the recorded JPEG images of every camera."""
    import rerun as rr

    for camera, files in episode.images.items():
        path = f"/camera/{camera}"
        recording.log(path, rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
        times = frame_times(np.arange(len(files)), fps_of(episode))
        columns = rr.EncodedImage.columns(blob=list(files))
        recording.send_columns(path, indexes=times, columns=columns)


def log_frustums(recording: rr.RecordingStream, episode: Episode, poses: Poses) -> None:
    """Log where each camera is, at every frame if it moves, and what it sees from there."""
    import rerun as rr

    there = {name: model for name, model in episode.cameras.items() if name in poses}
    log_poses(recording, {name: poses[name] for name in there}, FRUSTUM, fps_of(episode))
    for name, model in there.items():
        pinhole = rr.Pinhole(
            image_from_camera=model.intrinsics,
            resolution=[model.width, model.height],
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=DEPTH,
        )
        recording.log(body_path(name, FRUSTUM), pinhole, static=True)


def log_about(recording: rr.RecordingStream, episode: Episode, title: str) -> None:
    """Log what is known of the episode as a table to read."""
    import rerun as rr

    known = {
        "robot": episode.robot,
        "task": episode.task,
        "seed": episode.seed if seed_of(episode) else "",
        "success": {"success": "yes", "failure": "no", None: ""}[outcome_of(episode)],
        "frames": len(episode),
        **{k: v for k, v in episode.metadata.items() if isinstance(v, str | int | float)},
    }
    rows = "\n".join(f"| {key} | {value} |" for key, value in known.items() if value != "")
    text = f"# {title}\n\n| | |\n|---|---|\n{rows}\n"
    recording.log("/about", rr.TextDocument(text, media_type="text/markdown"), static=True)
