"""Bags in MCAP by writers that are not this project's: mcap-ros2-support's, in CDR.

The definitions are those of ROS 2's own packages, as `ros2 bag record` puts them into a file.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer
from PIL import Image

SECOND = 10**9
START = 1_700_000_000 * SECOND  # ns, of the first message
LINE = "=" * 80 + "\n"
TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
HEADER = f"{LINE}MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{LINE}{TIME}"
POINTS = (
    f"{LINE}MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    f"{LINE}MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
)
VECTOR = f"{LINE}MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
LAYOUT = (
    f"{LINE}MSG: std_msgs/MultiArrayLayout\nstd_msgs/MultiArrayDimension[] dim\n"
    "uint32 data_offset\n"
    f"{LINE}MSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"
)
DEFINITIONS = {
    "sensor_msgs/msg/JointState": (
        "# joints\nstd_msgs/Header header\n\nstring[] name\nfloat64[] position\n"
        f"float64[] velocity\nfloat64[] effort\n{HEADER}"
    ),
    "sensor_msgs/msg/Image": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
        f"uint8 is_bigendian\nuint32 step\nuint8[] data\n{HEADER}"
    ),
    "sensor_msgs/msg/CompressedImage": (
        f"std_msgs/Header header\nstring format\nuint8[] data\n{HEADER}"
    ),
    "geometry_msgs/msg/PoseStamped": (
        f"std_msgs/Header header\ngeometry_msgs/Pose pose\n{HEADER}{LINE}MSG: geometry_msgs/Pose\n"
        f"geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n{POINTS}"
    ),
    "geometry_msgs/msg/Twist": (
        f"geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n{VECTOR}"
    ),
    "geometry_msgs/msg/WrenchStamped": (
        f"std_msgs/Header header\ngeometry_msgs/Wrench wrench\n{HEADER}"
        f"{LINE}MSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\n"
        f"geometry_msgs/Vector3 torque\n{VECTOR}"
    ),
    "trajectory_msgs/msg/JointTrajectory": (
        "std_msgs/Header header\nstring[] joint_names\n"
        f"trajectory_msgs/JointTrajectoryPoint[] points\n{HEADER}"
        f"{LINE}MSG: trajectory_msgs/JointTrajectoryPoint\nfloat64[] positions\n"
        "float64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
        f"builtin_interfaces/Duration time_from_start\n"
        f"{LINE}MSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n"
    ),
    "std_msgs/msg/Float64MultiArray": f"std_msgs/MultiArrayLayout layout\nfloat64[] data\n{LAYOUT}",
    "std_msgs/msg/Float64": "float64 data\n",
    "std_msgs/msg/Bool": "bool data\n",
    "std_msgs/msg/String": "string data\n",
    "my_gripper_msgs/msg/GripperStatus": (
        "uint8 OPEN=0\nuint8 CLOSED=1\nfloat32 width\nmy_gripper_msgs/Finger[2] fingers\n"
        f"string model\n{LINE}MSG: my_gripper_msgs/Finger\nfloat32 force\nbool touches\n"
    ),
}  # fmt: skip

# A message: when it was recorded (s after START), its topic, type and content.
Said = tuple[float, str, str, Mapping[str, Any]]


def ns(seconds: float) -> int:
    return START + round(seconds * SECOND)


def header(seconds: float) -> dict[str, Any]:
    time = ns(seconds)
    return {"stamp": {"sec": time // SECOND, "nanosec": time % SECOND}, "frame_id": "base_link"}


def write(
    path: Path, messages: Iterable[Said], *, compression: CompressionType = CompressionType.ZSTD,
    chunk_size: int = 4096,
) -> Path:  # fmt: skip
    """A bag of messages, in the order in which they are given."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk_size, compression=compression)
        schemas: dict[str, Any] = {}
        for number, (seconds, topic, type, content) in enumerate(messages):
            if type not in schemas:
                schemas[type] = writer.register_msgdef(type, DEFINITIONS[type])
            time = ns(seconds)
            writer.write_message(topic, schemas[type], content, time, time, number)
        writer.finish()
    return path


def joints(
    topic: str, seconds: float, names: Sequence[str], position: Sequence[float],
    *, late: float = 0.0, **more: Any,
) -> Said:  # fmt: skip
    """A JointState measured at `seconds`, recorded `late` seconds later."""
    content = {"header": header(seconds), "name": list(names), "position": list(position)}
    empty = {"velocity": [], "effort": []}
    return seconds + late, topic, "sensor_msgs/msg/JointState", {**content, **empty, **more}


def picture(level: int, width: int = 48, height: int = 40) -> np.ndarray:
    """A picture (H, W, 3) of one level of red, that tells frames apart."""
    image = np.zeros((height, width, 3), np.uint8)
    image[..., 0] = level
    image[..., 1] = np.linspace(0, 200, width)
    return image


def compressed(
    topic: str, seconds: float, image: np.ndarray, *, late: float = 0.0, format: str = "jpeg"
) -> Said:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format, quality=95)
    content = {"header": header(seconds), "format": format, "data": buffer.getvalue()}
    return seconds + late, topic, "sensor_msgs/msg/CompressedImage", content


def raw(
    topic: str, seconds: float, image: np.ndarray, encoding: str, *, padding: int = 0,
    late: float = 0.0,
) -> Said:  # fmt: skip
    """An Image of an array that has the encoding's own channels; rows padded by some bytes."""
    rows = image.reshape(image.shape[0], -1).view(np.uint8)
    data = np.pad(rows, ((0, 0), (0, padding)))
    content = {
        "header": header(seconds), "height": image.shape[0], "width": image.shape[1],
        "encoding": encoding, "is_bigendian": 0, "step": data.shape[1], "data": data.tobytes(),
    }  # fmt: skip
    return seconds + late, topic, "sensor_msgs/msg/Image", content


def in_time(messages: Iterable[Said]) -> list[Said]:
    return sorted(messages, key=lambda said: said[0])
