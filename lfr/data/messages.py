"""Protobuf messages of an episode's log that no Foxglove schema covers.

The messages are built from the names of their dimensions, so `/action.gripper` or
`/observation.cube_pos_z` is a series that Foxglove and rerun plot by name. They use proto2: its
fields have presence, so 0.0 and -0.0 are written as they are (proto3 drops both).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cache, lru_cache

from foxglove import Schema
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message

JOINT_STATES = "/joint_states"
TRANSFORMS = "/tf"
ACTION = "/action"
OBSERVATION = "/observation"
REWARD = "/reward"
SUCCESS = "/success"
SIMULATOR_STATE = "/simulator_state"
CAMERA = "/camera/"  # + camera name; its calibration at /camera/<name>/calibration
CALIBRATION = "/calibration"

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
