"""An episode's own MCAP file, written while the episode happens.

Topics, all at simulated time t / fps:

    /joint_states            foxglove.JointStates      positions (rad), velocities (rad/s)
    /tf                      foxglove.FrameTransforms  world -> each body, object, camera (m)
    /observation, /action    lfr.Observation, lfr.Action: one double per named dimension
    /executed_action         lfr.Action                where noise was added to the action
    /reward, /success        lfr.Reward, lfr.Success   what came of the action of that frame
    /simulator_state         lfr.SimulatorState        float64, T + 1 of them: a log replays
    /camera/<name>           foxglove.CompressedImage  JPEG
    /camera/<name>/calibration  foxglove.CameraCalibration, once, when it is known

and the metadata records `episode`, `features`, `provenance` and `outcome`. Nothing in it comes
from the clock: the same episode recorded again by the same revision is the same file, byte by byte.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfr.artifacts import provenance
from lfr.data import messages
from lfr.data.episode import ACTION, JOINT_POSITION, EpisodeInfo
from lfr.data.mcap_writer import McapWriter
from lfr.data.messages import CameraModel, Pose

FLUSH_FRAMES = 20  # a crash costs at most one second (measured: 905 of 910 messages recovered)
# Seeds start 100 s apart from 2000-01-01 on (the longest horizon is 15 s), so that episodes
# opened together in a viewer stand one after the other.
EPOCH_NS = 946_684_800 * 10**9
SEED_NS = 100 * 10**9


@dataclass(frozen=True)
class Frame:
    """One control step t: what was observed before the action, the action, and what came of it.

    `observation` (D,) is observation.state followed by observation.environment_state and whatever
    else is observed (`lfr.data.episode.observed`), `simulator_state` (S,) the state before the
    action, nothing where it cannot be had, `body_poses` positions (3,) in metres and
    quaternions (4,) wxyz in the world, those of cameras that move among them, `images` (H, W, 3)
    uint8. `executed_action` (A,) is what the simulator was given, where noise was added to
    `action`, which is then the label to learn.
    """

    observation: NDArray[np.float64]
    joint_position: NDArray[np.float64] | None
    action: NDArray[np.float64]
    reward: float
    success: bool
    simulator_state: NDArray[np.float64]
    executed_action: NDArray[np.float64] | None = None
    joint_velocity: NDArray[np.float64] | None = None
    body_poses: Mapping[str, Pose] = field(default_factory=dict)
    images: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)


class EpisodeLog:
    """Writer of one episode's MCAP file.

        with EpisodeLog(path, info) as log:
            log.frame(Frame(...))  # T times
            log.finish(simulator_state)

    The file is `<path>.partial` until `finish`, which syncs and renames it. Leaving the block
    without `finish`, or through an error, abandons the episode: nothing stays. A killed process
    leaves the `.partial`, of which all but the last second can be recovered.
    """

    def __init__(
        self, path: Path, info: EpisodeInfo, cameras: Mapping[str, CameraModel] | None = None
    ) -> None:
        self._info = info
        self._cameras = dict(cameras or {})
        self._start = EPOCH_NS + info.seed * SEED_NS
        self._frames, self._success = 0, False
        self._file = McapWriter(path)
        action = messages.record("Action", info.names(ACTION))
        self._schemas = {
            messages.OBSERVATION: messages.record("Observation", info.observation_names),
            messages.ACTION: action,
            messages.EXECUTED_ACTION: action,
            messages.REWARD: messages.record("Reward", ("reward",)),
            messages.SUCCESS: messages.record("Success", ("success",)),
            messages.SIMULATOR_STATE: messages.vector("SimulatorState"),
        }
        self._encoders = {topic: messages.encoder(s) for topic, s in self._schemas.items()}
        self._write_metadata()

    def frame(self, frame: Frame) -> None:
        """Log one control step.

        Raises:
            ValueError: a vector has another length than the names given at the start.
            DataError: the disk is full.
        """
        now = self._now()
        self._log_record(messages.OBSERVATION, frame.observation, now)
        self._log_record(messages.ACTION, frame.action, now)
        if frame.executed_action is not None:
            self._log_record(messages.EXECUTED_ACTION, frame.executed_action, now)
        self._log_record(messages.REWARD, [frame.reward], now)
        self._log_record(messages.SUCCESS, [frame.success], now)
        self._log_record(messages.SIMULATOR_STATE, frame.simulator_state, now)
        if frame.joint_position is not None:
            joints = messages.joint_states(
                self._info.names(JOINT_POSITION), frame.joint_position, frame.joint_velocity, now
            )
            self._file.log(messages.JOINT_STATES, joints, now)
        self._log_transforms(frame.body_poses, now)
        for camera, image in frame.images.items():
            self._log_image(camera, image, now)
        self._success |= bool(frame.success)
        self._frames += 1
        if self._frames % FLUSH_FRAMES == 0:
            self._file.flush()

    def finish(
        self,
        simulator_state: NDArray[np.float64],
        body_poses: Mapping[str, Pose] | None = None,
        success: bool | None = None,
    ) -> Path:
        """Log the state after the last action, close the file and give it its name.

        Args:
            simulator_state: (S,) after the last action.
            body_poses: as in `Frame`, after the last action.
            success: the episode's outcome; by default, whether any frame was a success.

        Raises:
            DataError: not everything that was logged reached the file, as on a full disk.
            ValueError: no frame was logged.
        """
        if not self._frames:
            raise ValueError("an episode has at least one frame")
        self._log_record(messages.SIMULATOR_STATE, simulator_state, self._now())
        self._log_transforms(body_poses or {}, self._now())
        outcome = {
            "frames": self._frames,
            "success": self._success if success is None else bool(success),
        }
        self._file.finish(outcome=outcome)
        return self._file.path

    def abandon(self) -> None:
        """Close and remove the unfinished file."""
        self._file.abandon()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if not self._file.finished:
            self.abandon()

    def _now(self) -> int:
        return self._start + self._frames * (10**9 // self._info.fps)

    def _write_metadata(self) -> None:
        info, keys = self._info, ("robot", "task", "seed", "instruction", "attempt", "controller")
        named = {**{key: getattr(info, key) for key in keys}, "fps": info.fps, **info.extra}
        schema = {
            key: {"dtype": f.dtype, "shape": f.shape, "names": f.names, "about": f.about}
            for key, f in self._info.features.items()
        }
        self._file.metadata(
            episode={**named, "created_by": "lfr"}, features=schema, provenance=_provenance()
        )

    def _log_record(self, topic: str, values: ArrayLike, now: int) -> None:
        data = self._encoders[topic](np.asarray(values, np.float64).tolist())
        self._file.log(topic, data, now, self._schemas[topic])

    def _log_transforms(self, poses: Mapping[str, Pose], now: int) -> None:
        if poses:
            self._file.log(messages.TRANSFORMS, messages.transforms(poses, now), now)

    def _log_image(self, camera: str, image: NDArray[np.uint8], now: int) -> None:
        topic = messages.CAMERA + camera
        if self._file.counts[topic] == 0 and camera in self._cameras:
            model = self._cameras[camera]
            calibration = messages.calibration(camera, model, now)
            self._file.log(topic + messages.CALIBRATION, calibration, now)
            if model.position is not None and model.quaternion is not None:
                self._log_transforms({camera: (model.position, model.quaternion)}, now)
        self._file.log(topic, messages.jpeg(camera, image, now), now)


@cache
def _provenance() -> dict[str, Any]:
    return provenance()  # asks git: once for a process, not once for an episode
