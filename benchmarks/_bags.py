"""Made-up ROS 2 bags of any size, by the writer of mcap-ros2-support."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer
from numpy.typing import NDArray
from PIL import Image

CAMERAS = ("front", "wrist")
WIDTH, HEIGHT = 640, 480
JOINTS = tuple(f"joint_{i}" for i in range(1, 8))
JOINT_RATE, PICTURE_RATE, GRIPPER_RATE = 100, 25, 10  # Hz; JOINT_RATE is a multiple of the others
EPISODE, PAUSE = 30, 2  # s
NOISE = 20  # levels of standard deviation: a picture of about 250 kB, no two alike

MAPPING = """\
fps: {fps}
task: push the cube
features:
  observation.state:
    - {{topic: /joint_states, field: position}}
    - {{topic: /gripper/width}}
  observation.images.front: {{topic: /front/image_raw/compressed}}
  observation.images.wrist: {{topic: /wrist/image_raw/compressed}}
  action: {{next: observation.state}}
episodes: {{gap: 1.0}}
"""

_LINE = "=" * 80
_HEADER = (
    f"{_LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{_LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
_DEFINITIONS = {
    "sensor_msgs/msg/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        f"float64[] effort\n{_HEADER}"
    ),
    "sensor_msgs/msg/CompressedImage": (
        f"std_msgs/Header header\nstring format\nuint8[] data\n{_HEADER}"
    ),
    "std_msgs/msg/Float64": "float64 data\n",
}
_START = 1_700_000_000  # s
_CHUNK = 768 * 1024  # bytes, as rosbag2 writes


@dataclass(frozen=True)
class Written:
    """How much a bag holds."""

    bytes: int
    seconds: float
    messages: int
    pictures: int


def write_bag(path: Path, size: int) -> Written:
    """Write a bag that is as large as `size`, bytes, or a little larger.

    Two cameras in JPEG, seven joints and a gripper, in episodes with pauses between. The same size
    gives the same bag.
    """
    messages = pictures = 0
    now = 0.0
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=_CHUNK, compression=CompressionType.NONE)
        schemas = {t: writer.register_msgdef(t, text) for t, text in _DEFINITIONS.items()}
        for seconds, topic, type, content in _messages():
            if stream.tell() >= size:
                break
            nanoseconds = round((_START + seconds) * 1e9)
            writer.write_message(topic, schemas[type], content, nanoseconds, nanoseconds, messages)
            messages += 1
            pictures += type == "sensor_msgs/msg/CompressedImage"
            now = seconds
        writer.finish()
    return Written(path.stat().st_size, now, messages, pictures)


def _messages() -> Iterator[tuple[float, str, str, dict[str, Any]]]:
    """Messages without end: when, on which topic, of which type, and what."""
    rng = np.random.default_rng(0)
    noise = rng.normal(0, NOISE, (2 * HEIGHT, 2 * WIDTH, 3)).astype(np.int16)
    step = 0
    while True:
        seconds = step / JOINT_RATE
        seconds += PAUSE * (seconds // EPISODE)
        time = round((_START + seconds) * 1e9)
        stamp = {"sec": time // 10**9, "nanosec": time % 10**9}
        header = {"stamp": stamp, "frame_id": "base_link"}
        angles = np.sin(seconds + np.arange(len(JOINTS)))
        yield seconds, "/joint_states", "sensor_msgs/msg/JointState", {
            "header": header, "name": list(JOINTS), "position": angles.tolist(),
            "velocity": np.cos(angles).tolist(), "effort": angles.tolist(),
        }  # fmt: skip
        if step % (JOINT_RATE // GRIPPER_RATE) == 0:
            yield seconds, "/gripper/width", "std_msgs/msg/Float64", {"data": 0.08}
        if step % (JOINT_RATE // PICTURE_RATE) == 0:
            for camera in CAMERAS:
                topic, type = f"/{camera}/image_raw/compressed", "sensor_msgs/msg/CompressedImage"
                down, right = rng.integers(HEIGHT), rng.integers(WIDTH)
                grain = noise[down : down + HEIGHT, right : right + WIDTH]
                data = _jpeg(_scene(seconds, camera) + grain)
                yield seconds, topic, type, {"header": header, "format": "jpeg", "data": data}
        step += 1


def _scene(seconds: float, camera: str) -> NDArray[np.int16]:
    """Waves that move, (HEIGHT, WIDTH, 3)."""
    phase = seconds + CAMERAS.index(camera)
    across = 60 * np.sin(np.arange(WIDTH) / 37 + phase)
    down = 50 * np.sin(np.arange(HEIGHT) / 23 - phase)
    grey = 128 + across[None, :, None] + down[:, None, None]
    return (grey + np.array([0, 15, -15])).astype(np.int16)


def _jpeg(pixels: NDArray[np.int16]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(np.clip(pixels, 0, 255).astype(np.uint8)).save(buffer, "JPEG", quality=95)
    return buffer.getvalue()
