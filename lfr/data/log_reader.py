"""Reading an episode's MCAP log back, exactly."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError, Message
from mcap.records import Schema
from numpy.typing import NDArray

from lfr.artifacts import parse_json
from lfr.data import messages
from lfr.data.episode import (
    ACTION,
    DONE,
    JOINT_POSITION,
    REWARD,
    STATE,
    SUCCESS,
    Episode,
    observed,
)
from lfr.data.mcap_file import open_whole
from lfr.data.messages import EXECUTED_ACTION, SIMULATOR_STATE, CameraModel
from lfr.errors import DataError

ALWAYS = (messages.OBSERVATION, messages.ACTION, messages.REWARD, messages.SUCCESS)
PER_FRAME = (*ALWAYS, messages.JOINT_STATES)  # where joints are recorded
STRUCTURED = ("features", "outcome")  # metadata records whose values are JSON
INTEGERS = ("seed", "attempt", "fps")  # in the record `episode`


def list_logs(folder: Path) -> list[Path]:
    """The finished logs of a folder, by name.

    Raises:
        DataError: there is no such folder, or no log in it.
    """
    logs = sorted(Path(folder).glob("*.mcap"))
    if not logs:
        unfinished = len(list(Path(folder).glob("*.mcap.partial")))
        raise DataError(
            "no logs; record episodes first",
            file=folder,
            found=f"{unfinished} unfinished" if unfinished else "none",
            expected="*.mcap",
        )
    return logs


def read_log(path: Path) -> Episode:
    """The episode that a log holds: every value as it was logged, features in their dtypes.

    Raises:
        DataError: the file is missing, no MCAP, cut off, damaged, or not a log of this project.
    """
    path = Path(path)
    read = _read(path, _decoders)
    try:
        return _episode(path, *read)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise DataError(
            "metadata of another form than lfr writes",
            file=path,
            found=f"{type(error).__name__}: {error}",
        ) from error


def _episode(
    path: Path,
    values: dict[str, list[Any]],
    images: dict[str, list[bytes]],
    metadata: dict[str, dict[str, Any]],
) -> Episode:
    if not {"episode", "features", "outcome"} <= set(metadata):
        raise DataError(
            "a foreign or unfinished MCAP file, not a log of lfr",
            file=path,
            found=f"metadata {sorted(metadata) or 'none'}",
            expected="metadata episode, features, outcome",
        )
    numbers = {**{key: metadata["episode"].get(key, 1) for key in INTEGERS},
               "frames": metadata["outcome"]["frames"]}  # fmt: skip
    for key, value in numbers.items():
        if not isinstance(value, int) or isinstance(value, bool) or (key == "fps" and value < 1):
            raise ValueError(f"{key} {value!r:.40}")
    if not isinstance(metadata["outcome"]["success"], bool):
        raise ValueError(f"success {metadata['outcome']['success']!r:.40}")
    features, seen = metadata["features"], observed(metadata["features"])
    for key in (*(() if seen else (STATE,)), ACTION, REWARD, SUCCESS, DONE):
        if key not in features:
            found = ", ".join(features)
            raise DataError("a feature is missing", file=path, column=key, found=found)
    frames = metadata["outcome"]["frames"]
    joints = (JOINT_POSITION,) if JOINT_POSITION in features else ()
    per_frame = PER_FRAME if joints else ALWAYS
    counts = {topic: (len(values.get(topic, ())), frames) for topic in per_frame}
    counts[SIMULATOR_STATE] = (len(values.get(SIMULATOR_STATE, ())), frames + 1)
    counts |= {messages.CAMERA + name: (len(files), frames) for name, files in images.items()}
    if EXECUTED_ACTION in values:
        counts[EXECUTED_ACTION] = (len(values[EXECUTED_ACTION]), frames)
    for topic, (found, expected) in counts.items():
        if found != expected:
            raise DataError(
                "messages are missing; record the episode again",
                file=path,
                column=topic,
                found=f"{found} messages",
                expected=expected,
            )
    # MCAP sorts a record by key; this is the order of the columns below
    schema = {key: features[key] for key in (*seen, *joints, ACTION, REWARD, SUCCESS, DONE)}
    rows = {topic: _stack(values[topic], topic, path) for topic in (*per_frame, SIMULATOR_STATE)}
    executed = values.get(EXECUTED_ACTION, values[messages.ACTION])
    observation = rows[messages.OBSERVATION]
    splits = np.cumsum([len(schema[key]["names"]) for key in seen])[:-1]
    done = np.zeros(frames, bool)
    done[-1:] = True
    columns = {
        **dict(zip(seen, np.split(observation, splits, axis=1), strict=True)),
        **{key: rows[messages.JOINT_STATES] for key in joints},
        ACTION: rows[messages.ACTION],
        REWARD: rows[messages.REWARD][:, 0],
        SUCCESS: rows[messages.SUCCESS][:, 0],
        DONE: done,
    }
    for key, column in columns.items():
        expected = () if column.ndim == 1 else (len(schema[key]["names"]),)
        if column.shape[1:] != expected:
            raise DataError(
                "another shape than the log's own schema says",
                file=path,
                column=key,
                found=column.shape[1:],
                expected=expected,
            )
    about = metadata["episode"]
    return Episode(
        robot=about["robot"],
        task=about["task"],
        seed=about["seed"],
        success=metadata["outcome"]["success"],
        features={key: column.astype(schema[key]["dtype"]) for key, column in columns.items()},
        simulator_state=rows[SIMULATOR_STATE],
        executed_action=_stack(executed, EXECUTED_ACTION, path),
        images=images,
        cameras=_cameras(values),
        metadata={**about, "features": schema, "provenance": metadata.get("provenance", {})},
    )


def body_poses(path: Path) -> dict[str, NDArray[np.float64]]:
    """Poses in the world of every body and object of a log: (N, 7), x y z (m) and qw qx qy qz.

    N is T + 1 where the final poses were logged, else T; a fixed camera's, logged once, is (1, 7).

    Raises:
        DataError: as `read_log`.
    """
    values, _, _ = _read(Path(path), lambda topic: _poses if topic == messages.TRANSFORMS else None)
    poses: dict[str, list[list[float]]] = defaultdict(list)
    for named in values.get(messages.TRANSFORMS, ()):
        for name, pose in named:
            poses[name].append(pose)
    return {name: np.array(rows) for name, rows in poses.items()}


Decoder = Callable[[Message], Any]


def _decoders(topic: str) -> Decoder | None:
    if topic == SIMULATOR_STATE:
        return _vector
    if _calibrates(topic):
        return _calibration
    if topic == messages.JOINT_STATES:
        return _joint_positions
    return _record if topic in (*PER_FRAME, EXECUTED_ACTION) else None


def _calibrates(topic: str) -> bool:
    return topic.startswith(messages.CAMERA) and topic.endswith(messages.CALIBRATION)


def _cameras(values: Mapping[str, list[Any]]) -> dict[str, CameraModel]:
    return {
        topic.removeprefix(messages.CAMERA).removesuffix(messages.CALIBRATION): found[-1]
        for topic, found in values.items()
        if _calibrates(topic)
    }


@cache
def _getter(cls: type[Message]) -> Callable[[Message], Any]:
    return attrgetter(*messages.field_names(cls))


def _record(message: Message) -> Any:
    return _getter(type(message))(message)


def _vector(message: Any) -> NDArray[np.float64]:
    return np.array(message.value)


def _joint_positions(message: Any) -> list[float]:
    return [joint.position for joint in message.joints]


def _calibration(message: Any) -> CameraModel:
    return CameraModel(message.width, message.height, np.reshape(message.K, (3, 3)))


def _poses(message: Any) -> list[tuple[str, list[float]]]:
    poses = []
    for transform in message.transforms:
        p, q = transform.translation, transform.rotation
        poses.append((transform.child_frame_id, [p.x, p.y, p.z, q.w, q.x, q.y, q.z]))
    return poses


def _read(
    path: Path, decoder_of: Callable[[str], Decoder | None]
) -> tuple[dict[str, list[Any]], dict[str, list[bytes]], dict[str, dict[str, Any]]]:
    """Decoded messages by topic, JPEG files by camera, metadata by record."""
    values: dict[str, list[Any]] = defaultdict(list)
    images: dict[str, list[bytes]] = defaultdict(list)
    with open_whole(path) as reader:
        metadata = {
            record.name: _parse(record.name, record.metadata) for record in reader.iter_metadata()
        }
        try:
            for schema, channel, message in reader.iter_messages(log_time_order=False):
                topic = channel.topic
                is_image = schema is not None and schema.name == "foxglove.CompressedImage"
                if is_image and topic.startswith(messages.CAMERA):
                    image: Any = _class(schema).FromString(message.data)
                    images[topic.removeprefix(messages.CAMERA)].append(image.data)
                elif schema is not None and (decode := decoder_of(topic)) is not None:
                    values[topic].append(decode(_class(schema).FromString(message.data)))
        except (DecodeError, KeyError, TypeError, AttributeError) as error:
            raise DataError(
                "a foreign MCAP file, not a log of lfr",
                file=path,
                found=f"{type(error).__name__}: {error}",
                expected="messages of the schemas that lfr writes",
            ) from error
    return dict(values), dict(images), metadata


def _class(schema: Schema | None) -> type[Message]:
    if schema is None:
        raise TypeError("a message without a schema")
    return messages.message_class(schema.name, schema.data)


def _parse(name: str, record: Mapping[str, str]) -> dict[str, Any]:
    """Numbers and structure where the writer put them; every other text stays a text."""
    parsed = INTEGERS if name == "episode" else record if name in STRUCTURED else ()
    return {key: parse_json(text) if key in parsed else text for key, text in record.items()}


def _stack(rows: list[Any], topic: str, path: Path) -> NDArray[np.float64]:
    lengths = {np.size(row) for row in rows}
    if len(lengths) > 1:
        raise DataError("messages of different lengths", file=path, column=topic, found=lengths)
    return np.array(rows, np.float64).reshape(len(rows), *lengths)
