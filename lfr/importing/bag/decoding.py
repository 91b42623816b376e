"""Messages out of bytes: ROS 2's CDR, JSON and protobuf, and their fields by name whichever it is.

A decoded message is an object of `mcap_ros2`, a dict, or a protobuf message.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

from google.protobuf.message import Message as ProtobufMessage
from mcap.records import Schema

SUPPORTED = "cdr by a ros2msg schema, protobuf, json"
STAMPS = (("header", "stamp"), ("timestamp",), ("stamp",))
SECONDS, NANOSECONDS = ("sec", "secs", "seconds"), ("nanosec", "nsec", "nsecs", "nanos")
_FIRST_FIELD = re.compile(r"(std_msgs/(msg/)?)?Header\s+\w+")
_STAMP = {True: struct.Struct("<iI"), False: struct.Struct(">iI")}


class MessageError(ValueError):
    """A message that is not what it should be, in words."""


class Decoders:
    """What decodes the messages of one file, whose schemas are known by their numbers."""

    def __init__(self) -> None:
        from mcap_protobuf.decoder import DecoderFactory as Protobuf
        from mcap_ros2.decoder import DecoderFactory as Ros2

        self._factories = (Ros2(), Protobuf())

    def of(self, encoding: str, schema: Schema | None) -> Callable[[bytes], Any]:
        """A function that decodes a message, or raises MessageError.

        Raises:
            MessageError: there is none for these messages.
        """
        decode = json.loads if encoding == "json" else self._known(encoding, schema)
        if decode is None:
            found = f"schema {schema.encoding or 'unnamed'}" if schema else "no schema"
            raise MessageError(f"messages in {encoding or 'no encoding'} with {found}; "
                               f"supported: {SUPPORTED}")  # fmt: skip

        def decoded(data: bytes) -> Any:
            if encoding == "cdr" and data[1:2] not in (b"\0", b"\1"):
                raise MessageError(f"CDR of kind {data[:2].hex() or 'none'}, not XCDR1")
            try:
                return decode(data)
            except Exception as error:  # whatever a library meets in bytes that it did not expect
                raise MessageError(f"bytes that do not decode: {_words(error)}") from error

        return decoded

    @staticmethod
    def header_first(schema: Schema | None) -> bool:
        return schema is not None and schema.encoding == "ros2msg" and _header_first(schema.data)

    def _known(self, encoding: str, schema: Schema | None) -> Callable[[bytes], Any] | None:
        try:
            for factory in self._factories:
                if decode := factory.decoder_for(encoding, schema):
                    return decode
        except Exception as error:  # the parsers of schemas have a dozen exceptions of their own
            name = schema.name if schema else ""
            raise MessageError(f"a schema of {name} that cannot be read: {_words(error)}") from None
        return None


def fields(message: Any) -> tuple[str, ...]:
    """The names of a message's fields; none of anything else."""
    if isinstance(message, SimpleNamespace):
        return tuple(type(message).__slots__)  # pyright: ignore[reportAttributeAccessIssue]
    if isinstance(message, ProtobufMessage):
        return tuple(field.name for field in message.DESCRIPTOR.fields)
    return tuple(map(str, message)) if isinstance(message, Mapping) else ()


def get(message: Any, name: str) -> Any:
    """A field of a message.

    Raises:
        MessageError: there is none of this name; those there are are listed.
    """
    if name not in (there := fields(message)):
        raise MessageError(f"no field {name!r}; there is {', '.join(there) or 'none'}")
    return message[name] if isinstance(message, Mapping) else getattr(message, name)


def is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def stamp_of(message: Any) -> int | None:
    """The time of measurement that a message carries, ns; None where it has none, or 0."""
    for path in STAMPS:
        value = message
        for name in path:
            value = get(value, name) if name in fields(value) else None
        there = fields(value)
        seconds = next((get(value, name) for name in SECONDS if name in there), None)
        rest = next((get(value, name) for name in NANOSECONDS if name in there), None)
        if isinstance(seconds, int) and isinstance(rest, int):
            return (seconds * 10**9 + rest) or None
    return None


def stamp_in_cdr(data: bytes) -> int | None:
    """The stamp of a message that begins with its header, without decoding the rest.

    Raises:
        MessageError: it is too short.
    """
    if len(data) < 12:
        raise MessageError(f"a message of {len(data)} bytes")
    seconds, rest = _STAMP[bool(data[1] & 1)].unpack_from(data, 4)
    return (seconds * 10**9 + rest) or None


@cache
def _header_first(schema: bytes) -> bool:
    for line in schema.decode("utf-8", "replace").splitlines():
        line = line.split("#")[0].strip()
        if line and "=" not in line.split('"')[0]:  # a constant is no field
            return _FIRST_FIELD.match(line) is not None
    return False


def _words(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]
