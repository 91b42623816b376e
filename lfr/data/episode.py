"""An episode, and the schema of every feature that is recorded of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lfr.controllers.controller import CONTROL_FREQUENCY
from lfr.embodiments import Embodiment
from lfr.spaces import ROBOT_STATE
from lfr.tasks import Task

if TYPE_CHECKING:
    from lfr.data.messages import CameraModel

FPS = CONTROL_FREQUENCY  # a frame is a control step
STATE = "observation.state"
ENVIRONMENT_STATE = "observation.environment_state"
JOINT_POSITION = "observation.joint_position"
ACTION = "action"
REWARD = "next.reward"
SUCCESS = "next.success"
DONE = "next.done"
IMAGES = "observation.images."  # + camera name


@dataclass(frozen=True)
class Feature:
    """Schema of one feature: a vector, or a scalar stored with shape (1,).

    `names` is None where the robot or the task decides them; `features` fills them in.
    """

    key: str
    dtype: str
    names: tuple[str, ...] | None
    about: str  # quantity, unit and frame, for the dataset card

    @property
    def shape(self) -> tuple[int, ...]:
        """(number of names,); a scalar has (1,), as LeRobot writes it."""
        return (len(self.names or ()),)


FEATURES: tuple[Feature, ...] = (
    Feature(
        STATE,
        "float32",
        None,
        "end effector in the robot's base frame: position (m), rotation as the first two columns "
        "of its matrix, gripper aperture (m) and gripper command in [-1, 1] (+1 closes)",
    ),
    Feature(
        ENVIRONMENT_STATE,
        "float32",
        None,
        "objects in the robot's base frame: positions and offsets (m), axes as unit vectors, yaw "
        "relative to the end effector as cosine and sine of its symmetry's multiple",
    ),
    Feature(JOINT_POSITION, "float32", None, "arm joint angles (rad), base to wrist"),
    Feature(
        ACTION,
        "float32",
        None,
        "what the controller was asked for, in [-1, 1]",
    ),
    Feature(REWARD, "float32", ("reward",), "robosuite's dense reward after the action"),
    Feature(SUCCESS, "bool", ("success",), "robosuite's success check after the action"),
    Feature(DONE, "bool", ("done",), "true at the episode's last frame"),
)


def features(
    state: Sequence[str],
    environment: Sequence[str],
    joints: Sequence[str],
    action: Sequence[str],
    action_about: str = "",
) -> dict[str, Feature]:
    """FEATURES with every dimension named, by key, in the order of a dataset's columns.

    Args:
        action_about: what the action is, in words, where the controller is known.
    """
    given = {STATE: state, ENVIRONMENT_STATE: environment, JOINT_POSITION: joints, ACTION: action}
    about = {ACTION: action_about} if action_about else {}
    return {
        f.key: Feature(
            f.key, f.dtype, tuple(given.get(f.key, f.names or ())), about.get(f.key, f.about)
        )
        for f in FEATURES
    }


def features_of(body: Embodiment, task: Task) -> dict[str, Feature]:
    """What is recorded of an embodiment in a task."""
    names = ROBOT_STATE.names, task.environment.names, body.robot.joints, body.action.names
    return features(*names, body.controller.about(body.robot))


NOT_OBSERVATION = (JOINT_POSITION, ACTION, REWARD, SUCCESS, DONE)


def observed(features: Iterable[str]) -> tuple[str, ...]:
    """Of the features those that a log's observation holds one after the other, in their order.

    `observation.state` and `observation.environment_state` come first, others by their names.
    """
    found = [key for key in features if key not in NOT_OBSERVATION]
    return tuple(sorted(found, key=lambda key: (key != STATE, key != ENVIRONMENT_STATE, key)))


@dataclass(frozen=True)
class EpisodeInfo:
    """What is known of an episode before its first frame, and kept with it.

    Attributes:
        robot: name of the embodiment: the arm, and what of it is not the default.
        task, seed: what was tried, from which start.
        instruction: the task in words.
        features: what is recorded, by key.
        attempt: counts the tries of this seed or worker; failed ones are not kept.
        controller: robosuite's name of the controller.
        fps: control steps, which are frames, per second.
        extra: whatever else the recorder knows.
    """

    robot: str
    task: str
    seed: int
    instruction: str
    features: Mapping[str, Feature]
    attempt: int = 0
    controller: str = ""
    fps: int = FPS
    extra: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls, body: Embodiment, task: Task, seed: int, extra: Mapping[str, str] | None = None
    ) -> EpisodeInfo:
        """What is known of an episode of an embodiment in a task that are simulated here."""
        return cls(
            robot=body.name,
            task=task.name,
            seed=seed,
            instruction=task.instruction,
            features=features_of(body, task),
            controller=body.controller.stock_name,
            extra=extra or {},
        )

    @property
    def observation_names(self) -> tuple[str, ...]:
        """Of all that is observed, in the order of `observed`."""
        return tuple(name for key in observed(self.features) for name in self.names(key))

    def names(self, key: str) -> tuple[str, ...]:
        """Of a feature's dimensions."""
        return self.features[key].names or ()


@dataclass(frozen=True)
class Episode:
    """One recorded episode of T frames.

    Row t of a feature is what was observed before action t, action t itself, and (`next.*`) what
    came of it.

    Attributes:
        features: by key, (T, *shape), a scalar feature (T,), each in its dtype.
        simulator_state: (T + 1, S) float64, before each action and, last, after the final one.
        executed_action: (T, A) float64, what the simulator was given, exactly: from
            simulator_state[0] it gives the other states again. It differs from the feature
            `action`, the label, where noise was added to it. None where only a dataset is left.
        images: by camera, T JPEG files.
        cameras: by name, what is known of how each sees; its pose is one of the log's poses.
        metadata: what the log says of itself: instruction, attempt, controller, fps, the schema of
            each feature, provenance.
    """

    robot: str
    task: str
    seed: int
    success: bool
    features: Mapping[str, np.ndarray]
    simulator_state: np.ndarray
    executed_action: np.ndarray | None = None
    images: Mapping[str, Sequence[bytes]] = field(default_factory=dict)
    cameras: Mapping[str, CameraModel] = field(default_factory=dict)
    metadata: Mapping[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.features[ACTION])

    @property
    def schema(self) -> dict[str, Feature]:
        """The schema of each feature, with the names that the log gives."""
        return {
            key: Feature(key, f["dtype"], tuple(f["names"]), f["about"])
            for key, f in self.metadata["features"].items()
        }
