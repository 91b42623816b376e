"""The messages of an episode's log: Foxglove's schemas, and our own where it has none.

Our own are built from the names of their dimensions, so `/action.gripper` or
`/observation.cube_pos_z` is a series that Foxglove and rerun plot by name. They use proto2: its
fields have presence, so 0.0 and -0.0 are written as they are (proto3 drops both).
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from foxglove import Schema
from foxglove.messages import (
    CameraCalibration,
    CompressedImage,
    FrameTransform,
    FrameTransforms,
    JointState,
    JointStates,
    Quaternion,
    Timestamp,
    Vector3,
)
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message
from numpy.typing import ArrayLike, NDArray

JOINT_STATES = "/joint_states"
TRANSFORMS = "/tf"
ACTION = "/action"
EXECUTED_ACTION = "/executed_action"
OBSERVATION = "/observation"
REWARD = "/reward"
SUCCESS = "/success"
SIMULATOR_STATE = "/simulator_state"
CAMERA = "/camera/"  # + camera name; its calibration at /camera/<name>/calibration
CALIBRATION = "/calibration"

JPEG_QUALITY = 92

Pose = tuple[ArrayLike, ArrayLike]  # position (3,) in m, quaternion (4,) wxyz


@dataclass(frozen=True)
class CameraModel:
    """A pinhole camera: size (pixels), intrinsic matrix (3, 3), and the pose (m, wxyz) in the
    world of its optical frame (x right, y down, z forward). Of a camera that moves the pose is
    None here, and under the camera's name among the poses of every frame."""

    width: int
    height: int
    intrinsics: NDArray[np.float64]
    position: NDArray[np.float64] | None = None
    quaternion: NDArray[np.float64] | None = None


_Field = descriptor_pb2.FieldDescriptorProto


def identifier(name: str) -> str:
    """A dimension's name as a protobuf field: `eef_pos.x` becomes `eef_pos_x`."""
    return re.sub(r"\W", "_", name)


@cache
def record(name: str, dimensions: tuple[str, ...]) -> Schema:
    """Schema of the message `lfr.<name>`: one double for each named dimension."""
    fields = [
        _Field(name=identifier(d), number=i, type=_Field.TYPE_DOUBLE, label=_Field.LABEL_OPTIONAL)
        for i, d in enumerate(dimensions, start=1)
    ]
    return _schema(name, fields)


@cache
def vector(name: str) -> Schema:
    """Schema of the message `lfr.<name>`: packed doubles in `value`, of any number."""
    field = _Field(name="value", number=1, type=_Field.TYPE_DOUBLE, label=_Field.LABEL_REPEATED)
    field.options.packed = True
    return _schema(name, [field])


def _schema(name: str, fields: list[_Field]) -> Schema:
    file = descriptor_pb2.FileDescriptorProto(
        name=f"lfr/{name}.proto",
        package="lfr",
        syntax="proto2",
        message_type=[descriptor_pb2.DescriptorProto(name=name, field=fields)],
    )
    data = descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)
    return Schema(name=f"lfr.{name}", encoding="protobuf", data=data)


@lru_cache(maxsize=64)
def message_class(name: str, data: bytes) -> type[Message]:
    """The class of message `name`, described by `data`, a serialised FileDescriptorSet.

    Raises google.protobuf's DecodeError, TypeError or KeyError when `data` does not describe it.
    """
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(name))


def field_names(cls: type[Message]) -> list[str]:
    """Names of a message's fields, in the order of their numbers."""
    return [field.name for field in cls.DESCRIPTOR.fields]


def encoder(schema: Schema) -> Callable[[Sequence[float]], bytes]:
    """A function that serialises a message of `record` or `vector` from its values, in order.

    It raises ValueError when a record is given another number of values than it has dimensions.
    """
    cls = message_class(schema.name, schema.data)
    names = field_names(cls)
    if names == ["value"]:
        return lambda values: cls(value=values).SerializeToString()
    return lambda values: cls(**dict(zip(names, values, strict=True))).SerializeToString()


def joint_states(
    names: Sequence[str], positions: ArrayLike, velocities: ArrayLike | None, ns: int
) -> JointStates:
    """Joint positions (rad) and, where they are known, velocities (rad/s)."""
    position = np.asarray(positions, np.float64).tolist()
    velocity = [None] * len(position)
    if velocities is not None:
        velocity = np.asarray(velocities, np.float64).tolist()
    joints = [
        JointState(name=n, position=p, velocity=v)
        for n, p, v in zip(names, position, velocity, strict=True)
    ]
    return JointStates(timestamp=_timestamp(ns), joints=joints)


def transforms(poses: Mapping[str, Pose], ns: int) -> FrameTransforms:
    """Poses of frames in the world."""
    return FrameTransforms(transforms=[_transform(name, *pose, ns) for name, pose in poses.items()])


def calibration(camera: str, model: CameraModel, ns: int) -> CameraCalibration:
    return CameraCalibration(
        timestamp=_timestamp(ns),
        frame_id=camera,
        width=model.width,
        height=model.height,
        K=np.ravel(model.intrinsics).tolist(),
        R=np.eye(3).ravel().tolist(),
        P=np.hstack([model.intrinsics, np.zeros((3, 1))]).ravel().tolist(),
    )


def jpeg(camera: str, image: NDArray[np.uint8], ns: int) -> CompressedImage:
    """An image (H, W, 3) as JPEG."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(buffer, "JPEG", quality=JPEG_QUALITY)
    return CompressedImage(
        timestamp=_timestamp(ns), frame_id=camera, data=buffer.getvalue(), format="jpeg"
    )


def _timestamp(ns: int) -> Timestamp:
    return Timestamp(sec=ns // 10**9, nsec=ns % 10**9)


def _transform(name: str, position: ArrayLike, quaternion: ArrayLike, ns: int) -> FrameTransform:
    x, y, z = np.asarray(position, np.float64).tolist()
    qw, qx, qy, qz = np.asarray(quaternion, np.float64).tolist()
    return FrameTransform(
        timestamp=_timestamp(ns),
        parent_frame_id="world",
        child_frame_id=name,
        translation=Vector3(x=x, y=y, z=z),
        rotation=Quaternion(x=qx, y=qy, z=qz, w=qw),
    )
