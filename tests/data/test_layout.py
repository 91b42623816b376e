"""What is said of LeRobot's layout is what LeRobot says, and is known without it."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfr.data import frames, layout, video

NAMES = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1)
DTYPES = ("float32", "float64", "bool", "int8", "int64", "uint8", "uint16")

# In a process of its own: in this one others have imported LeRobot.
WRITE = """
import sys
from pathlib import Path
import numpy as np
from PIL import Image
from lfr.data.frames import FrameWriter
from lfr.data.video import VideoWriter

root = Path(sys.argv[1])
rows = FrameWriter(root, {"action": {"dtype": "float32", "shape": (2,), "names": None}}, 20)
rows.write({"action": np.zeros((3, 2), np.float32)}, 0)
rows.close()
writer = VideoWriter(root, "top", "{chunk_index}-{file_index}.mp4", 20)
writer.begin()
for _ in range(3):
    writer.add(Image.new("RGB", (64, 64)))
writer.end()
writer.close()
print(*sorted({"torch", "lerobot", "datasets"} & set(sys.modules)))
"""


def test_names_and_sizes_of_files_are_lerobots() -> None:
    from lerobot.datasets import utils

    assert layout.EPISODES_PATH == utils.DEFAULT_EPISODES_PATH
    assert layout.DATA_PATH == utils.DEFAULT_DATA_PATH
    assert layout.VIDEO_PATH == utils.DEFAULT_VIDEO_PATH
    assert layout.CHUNK_SIZE == utils.DEFAULT_CHUNK_SIZE
    assert frames.MAX_BYTES == utils.DEFAULT_DATA_FILE_SIZE_IN_MB * 2**20
    assert video.MAX_BYTES == utils.DEFAULT_VIDEO_FILE_SIZE_IN_MB * 2**20
    place = {"chunk_index": 12, "file_index": 3}
    theirs = utils.DEFAULT_VIDEO_PATH.format(video_key="observation.images.top", **place)
    assert layout.video_path("observation.images.top").format(**place) == theirs


def test_the_columns_of_every_dataset_are_lerobots() -> None:
    from lerobot.utils.constants import DEFAULT_FEATURES

    assert layout.DEFAULT_FEATURES == DEFAULT_FEATURES
    assert list(layout.DEFAULT_FEATURES) == list(DEFAULT_FEATURES)


@settings(max_examples=50)
@given(st.dictionaries(NAMES, st.tuples(st.sampled_from(DTYPES), st.integers(1, 99))))
def test_the_schema_of_rows_is_lerobots(sizes: dict[str, tuple[str, int]]) -> None:
    from lerobot.datasets.feature_utils import get_hf_features_from_features

    features: dict[str, Any] = {
        key: {"dtype": dtype, "shape": (size,), "names": None}
        for key, (dtype, size) in sizes.items()
    } | layout.DEFAULT_FEATURES
    theirs = get_hf_features_from_features(features).arrow_schema
    assert layout.row_schema(features).equals(theirs, check_metadata=True)


def test_videos_are_encoded_as_lerobot_does_on_one_thread() -> None:
    from lerobot.configs.video import RGBEncoderConfig

    encoder = RGBEncoderConfig()
    assert (encoder.vcodec, encoder.pix_fmt) == (video.CODEC, video.PIXELS)
    assert encoder.get_codec_options(encoder_threads=1, as_strings=True) == video.OPTIONS


def test_rows_and_videos_are_written_without_lerobot(tmp_path: Path) -> None:
    command = [sys.executable, "-c", WRITE, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
    assert len(list(tmp_path.rglob("*.mp4"))) == 1


@pytest.mark.parametrize("shape", [(), (2, 3)])
def test_what_is_no_vector_has_no_place_in_a_row(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="unpack"):
        layout.row_schema({"action": {"dtype": "float32", "shape": shape}})
