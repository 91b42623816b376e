"""Wrote `rosbags_take/`, with rosbags 0.11 (Ternaris, Apache-2.0): `python rosbags_take.py FOLDER`.

rosbags is no dependency of this project; it is here as a writer that shares no code with the
readers. One second of two joints and a gripper at 20 Hz, and of pictures at 10 Hz.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image


def main(folder: Path) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    joint_state, number = types["sensor_msgs/msg/JointState"], types["std_msgs/msg/Float64"]
    image = types["sensor_msgs/msg/CompressedImage"]
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {
            topic: writer.add_connection(topic, type.__msgtype__, typestore=store)
            for topic, type in (
                ("/joint_states", joint_state),
                ("/gripper", number),
                ("/top/image_raw/compressed", image),
            )
        }

        def write(topic: str, seconds: float, message: object) -> None:
            connection = topics[topic]
            data = store.serialize_cdr(message, connection.msgtype)
            writer.write(connection, round((1_700_000_000 + seconds) * 1e9), data)

        for step in range(20):
            t = step / 20
            stamp = header(stamp=time(sec=1_700_000_000, nanosec=step * 50_000_000), frame_id="")
            none = np.zeros(0)
            state = joint_state(header=stamp, name=["a", "b"], position=np.array([t, -t]),
                                velocity=none, effort=none)  # fmt: skip
            write("/joint_states", t, state)
            write("/gripper", t, number(data=2 * t))
            if step % 2 == 0:
                buffer = io.BytesIO()
                Image.new("RGB", (40, 40), (9 * step, 100, 50)).save(buffer, "JPEG", quality=40)
                data = np.frombuffer(buffer.getvalue(), np.uint8)
                write("/top/image_raw/compressed", t, image(header=stamp, format="jpeg", data=data))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
