"""A robomimic demonstration as the features of a LeRobot dataset."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import (
    ACTION,
    DONE,
    ENVIRONMENT_STATE,
    IMAGES,
    JOINT_POSITION,
    REWARD,
    STATE,
    SUCCESS,
    Feature,
)
from lfr.errors import DataError
from lfr.importing.columns import Column, Quaternions, action_names, columns
from lfr.importing.robomimic import Demo, RobomimicFile

# Not "observation.": LeRobot's policies would take it for one.
SIMULATOR_STATE = "simulator_state"
JOINTS = "robot0_joint_pos"
IMAGE = "_image"  # what robosuite adds to a camera's name
SUCCESS_REWARD = 1.0  # robosuite's sparse reward

Successes = Literal["reward", "done", "last"]


@dataclass(frozen=True)
class Choice:
    """What is taken from a file, and how.

    Attributes:
        state, environment: observations of `observation.state` and of
            `observation.environment_state`, which is left out where there are none.
        action: the array of actions: "actions", or "actions_abs" where it is there.
        quaternions: as "rot6d" two columns of the rotation matrix, which have no sign to flip; or
            "keep" them. It concerns observations called `_quat`, not the parts of `object`.
        success: where `next.success` comes from, which a file does not say: a "reward" of 1 or
            more; "done" as recorded; or the "last" frame of every demonstration.
        video: make videos of the `_image` observations.
        simulator_states: keep `states`, float64.
    """

    state: tuple[str, ...] = ("robot0_eef_pos", "robot0_eef_quat", "robot0_gripper_qpos")
    environment: tuple[str, ...] = ("object",)
    action: str = "actions"
    quaternions: Quaternions = "rot6d"
    success: Successes = "reward"
    video: bool = True
    simulator_states: bool = False


@dataclass(frozen=True)
class Layout:
    """The features that a file's demonstrations become.

    Attributes:
        features: by key, in the order of the dataset's columns; videos aside.
        parts: the observations that make up a feature.
        cameras: of which there are videos.
        left_out: observations that are not imported.
    """

    choice: Choice
    features: dict[str, Feature]
    parts: dict[str, tuple[Column, ...]]
    cameras: tuple[str, ...]
    left_out: tuple[str, ...]

    @classmethod
    def of(cls, source: RobomimicFile, choice: Choice, demo: Demo) -> Layout:
        """The layout of a file whose first demonstration is `demo`.

        Raises:
            DataError: something that was chosen is not there.
        """
        there = demo.observations
        joints = (JOINTS,) if JOINTS in there and JOINTS not in choice.state else ()
        keys = {STATE: choice.state, ENVIRONMENT_STATE: choice.environment, JOINT_POSITION: joints}
        parts = {
            feature: columns(demo, chosen, source.env_args, choice.quaternions)
            for feature, chosen in keys.items()
            if chosen
        }
        cameras = tuple(
            key.removesuffix(IMAGE)
            for key, shape in there.items()
            if choice.video and key.endswith(IMAGE) and len(shape) == 3 and shape[2] == 3
        )
        used = {c.key for p in parts.values() for c in p} | {camera + IMAGE for camera in cameras}
        actions = action_names(source.env_args, choice.action, demo.vectors(choice.action).shape[1])
        names: dict[str, tuple[str, ...]] = {
            **{feature: sum((c.names for c in p), ()) for feature, p in parts.items()},
            ACTION: actions,
            REWARD: ("reward",),
            SUCCESS: ("success",),
            DONE: ("done",),
        }
        if JOINT_POSITION in names:
            names[JOINT_POSITION] = tuple(f"joint_{i}" for i in range(len(names[JOINT_POSITION])))
        if choice.simulator_states:
            size = demo.vectors("states").shape[1]
            names[SIMULATOR_STATE] = tuple(f"state.{i}" for i in range(size))
        features = {key: Feature(key, _dtype(key), given, "") for key, given in names.items()}
        left_out = tuple(sorted(set(there) - used))
        return cls(choice, features, parts, cameras, left_out)

    def read(self, demo: Demo) -> dict[str, NDArray]:
        """A demonstration's features, (T, D), scalars (T,).

        Raises:
            DataError: something is missing, not finite, or of another size than in the first.
        """
        demo.check_length()
        values: dict[str, NDArray] = {
            key: np.concatenate([column.read(demo) for column in parts], axis=1)
            for key, parts in self.parts.items()
        }
        last = np.arange(len(demo)) == len(demo) - 1
        values[ACTION] = self._sized(ACTION, demo, self.choice.action)
        values[REWARD] = demo.frames("rewards").reshape(-1).astype(np.float32)
        values[DONE] = last
        match self.choice.success:
            case "reward":
                values[SUCCESS] = values[REWARD] >= SUCCESS_REWARD
            case "done":
                values[SUCCESS] = demo.frames("dones").reshape(-1) != 0
            case "last":
                values[SUCCESS] = last
        if self.choice.simulator_states:
            values[SIMULATOR_STATE] = self._sized(SIMULATOR_STATE, demo, "states")
        return {key: values[key] for key in self.features}

    def images(self, demo: Demo, camera: str) -> Iterable[bytes]:
        """The frames of a camera as PNG files, which lose nothing before they are encoded."""
        from PIL import Image

        for frame in demo.frames(f"obs/{camera}{IMAGE}"):
            buffer = io.BytesIO()
            Image.fromarray(frame).save(buffer, "PNG", compress_level=1)
            yield buffer.getvalue()

    def _sized(self, key: str, demo: Demo, source: str) -> NDArray:
        feature, values = self.features[key], demo.frames(source)
        if values.shape[1:] != feature.shape:
            raise DataError(
                "another size than in the first demonstration", file=demo.file,
                column=f"{demo.name}/{source}", found=list(values.shape[1:]),
                expected=list(feature.shape),
            )  # fmt: skip
        return values.astype(feature.dtype)


def video_keys(cameras: Sequence[str]) -> dict[str, str]:
    """Camera -> its feature."""
    return {camera: IMAGES + camera for camera in cameras}


def _dtype(key: str) -> str:
    if key in (SUCCESS, DONE):
        return "bool"
    return "float64" if key == SIMULATOR_STATE else "float32"
