"""Which of robomimic's arrays make which feature, and what each dimension is called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lfr.errors import DataError
from lfr.importing.robomimic import EXTRACT, Demo
from lfr.spaces import Space, gripper_action, translation, turn

Quaternions = Literal["rot6d", "keep"]

XYZ, XYZW = ("x", "y", "z"), ("x", "y", "z", "w")
Parts = tuple[tuple[str, tuple[str, ...]], ...]
UNIT_TOLERANCE = 1e-3  # of a quaternion's norm
OSC_POSE = Space((translation(), turn(), gripper_action())).names


@dataclass(frozen=True)
class Column:
    """One observation as a part of a feature.

    Attributes:
        key: of the observation, such as "robot0_eef_quat".
        names: of the feature's dimensions that it makes.
        rotation: it is a quaternion (x, y, z, w), to be stored as two columns of its matrix.
    """

    key: str
    names: tuple[str, ...]
    rotation: bool = False

    def read(self, demo: Demo) -> NDArray[np.float32]:
        """Its values (T, D) in a demonstration.

        Raises:
            DataError: missing, another size than the first demonstration's, or no quaternion.
        """
        values = demo.frames(f"obs/{self.key}").reshape(len(demo), -1)
        size = 4 if self.rotation else len(self.names)
        if values.shape[1] != size:
            raise DataError(
                "another size than in the first demonstration", file=demo.file,
                column=f"{demo.name}/obs/{self.key}", found=values.shape[1], expected=size,
            )  # fmt: skip
        return (self._rot6d(values, demo) if self.rotation else values).astype(np.float32)

    def _rot6d(self, quaternions: NDArray, demo: Demo) -> NDArray:
        """The first column of the rotation matrix, then the second, as `lfr.data` has them."""
        from scipy.spatial.transform import Rotation

        norms = np.linalg.norm(quaternions, axis=1)
        wrong = np.abs(norms - 1.0) > UNIT_TOLERANCE
        if wrong.any():
            frame = int(wrong.argmax())
            raise DataError(
                "no unit quaternion; --quaternions keep takes it as it is", file=demo.file,
                column=f"{demo.name}/obs/{self.key}",
                found=f"{quaternions[frame].tolist()} in frame {frame}", expected="norm 1",
            )  # fmt: skip
        matrices = Rotation.from_quat(quaternions).as_matrix()  # (T, 3, 3)
        return matrices[:, :, :2].transpose(0, 2, 1).reshape(-1, 6)


def columns(
    demo: Demo, keys: Sequence[str], env_args: Mapping[str, Any], quaternions: Quaternions
) -> tuple[Column, ...]:
    """The observations called ``keys`` of a file whose first demonstration is ``demo``.

    Raises:
        DataError: there is no such observation; the message lists those there are.
    """
    return tuple(_column(demo, key, env_args, quaternions) for key in keys)


def object_parts(env_args: Mapping[str, Any]) -> Parts:
    """What robosuite put into `object` (its `object-state`), which the file does not say.

    robosuite 1.5 lists an object's pose in the hand before its pose in the world, earlier ones
    after it. `env_version` is that of the robosuite which wrote the observations. () where it is
    missing or the task is another: the dimensions are then numbered.
    """
    version = str(env_args.get("env_version", "")).split(".")[:2]
    env_name = env_args.get("env_name")
    if not all(part.isdigit() for part in version) or len(version) < 2:
        return ()
    if env_name == "Lift":
        return ("cube_pos", XYZ), ("cube_quat", XYZW), ("gripper_to_cube_pos", XYZ)
    name = {"PickPlaceCan": "Can", "NutAssemblySquare": "SquareNut"}.get(str(env_name))
    if name is None:
        return ()
    there = (f"{name}_pos", XYZ), (f"{name}_quat", XYZW)
    in_hand = (f"{name}_to_robot0_eef_pos", XYZ), (f"{name}_to_robot0_eef_quat", XYZW)
    before = tuple(int(part) for part in version) < (1, 5)
    return there + in_hand if before else in_hand + there


def _column(demo: Demo, key: str, env_args: Mapping[str, Any], quaternions: Quaternions) -> Column:
    there = demo.observations
    if key not in there:
        found = ", ".join(f"{name} {list(shape)}" for name, shape in there.items())
        raise DataError(
            "no such observation", file=demo.file, column=f"{demo.name}/obs",
            found=found or "none", expected=key if there else f"{key}; {EXTRACT}",
        )  # fmt: skip
    size = int(np.prod(there[key]))
    parts = object_parts(env_args) if key == "object" else ()
    named = tuple(f"{part}.{axis}" for part, axes in parts for axis in axes)
    if len(named) == size:
        return Column(key, named)
    stem, is_quaternion, place = key.partition("_quat")
    if is_quaternion and place in ("", "_site") and size == 4:
        if quaternions == "keep":
            return Column(key, tuple(f"{key}.{axis}" for axis in XYZW))
        return Column(key, tuple(f"{stem}{place}_rot6d.{i}" for i in range(6)), rotation=True)
    if key.endswith("_pos") and size == 3:
        return Column(key, tuple(f"{key}.{axis}" for axis in XYZ))
    return Column(key, (key,) if size == 1 else tuple(f"{key}.{i}" for i in range(size)))


def action_names(env_args: Mapping[str, Any], key: str, size: int) -> tuple[str, ...]:
    """Names of an action's dimensions: this project's for OSC_POSE deltas, else numbers."""
    if key == "actions" and size == len(OSC_POSE) and _is_osc_pose_delta(env_args):
        return OSC_POSE
    return tuple(f"action.{i}" for i in range(size))


def _is_osc_pose_delta(env_args: Mapping[str, Any]) -> bool:
    """robosuite up to 1.4 has one controller, from 1.5 on one for each part of the body."""
    kwargs = env_args.get("env_kwargs")
    whole = kwargs.get("controller_configs") if isinstance(kwargs, Mapping) else None
    whole = whole[0] if isinstance(whole, list) and whole else whole
    if not isinstance(whole, Mapping):
        return False
    parts = whole.get("body_parts")
    arm = parts.get("right", whole) if isinstance(parts, Mapping) else whole
    if not isinstance(arm, Mapping):
        return False
    delta = arm.get("control_delta", arm.get("input_type", "delta") == "delta")
    return arm.get("type") == "OSC_POSE" and bool(delta)
