"""The header read by hand against PyAV's reading of every packet."""

from pathlib import Path

import av
import numpy as np
import pytest

from lfr.curation.mp4 import BrokenVideoError, read_header
from tests.data.made_up import picture


def encode(path: Path, codec: str, frames: int, **options: str) -> Path:
    with av.open(str(path), "w") as out:
        stream = out.add_stream(codec, 20, options=options)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        for t in range(frames):
            image = picture(0, t, 96)[:64]
            out.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        out.mux(stream.encode())
    return path


@pytest.mark.parametrize(
    ("codec", "options", "reordered"),
    [
        ("libsvtav1", {"g": "2", "preset": "12"}, False),
        ("libx264", {"g": "5", "bf": "0"}, False),
        ("libx264", {"g": "12", "bf": "3"}, True),
    ],
)
def test_it_says_what_the_packets_say(
    tmp_path: Path, codec: str, options: dict[str, str], reordered: bool
) -> None:
    path = encode(tmp_path / "a.mp4", codec, 31, **options)
    header = read_header(path)
    with av.open(str(path)) as video:
        stream = video.streams.video[0]
        packets = [packet for packet in video.demux(stream) if packet.pts is not None]
        expected = sorted(float(packet.pts * stream.time_base) for packet in packets)
        keys = [i for i, packet in enumerate(packets) if packet.is_keyframe]
    np.testing.assert_allclose(header.times, np.array(expected) - expected[0], atol=1e-9)
    assert header.key_frames.tolist() == keys
    assert (header.width, header.height, header.frames) == (96, 64, 31)
    assert header.reordered == reordered


def test_what_is_no_whole_video_is_said(tmp_path: Path) -> None:
    whole = encode(tmp_path / "a.mp4", "libx264", 10).read_bytes()
    for kept in (0, 4, 20, 100, len(whole) // 2, len(whole) - 1):
        (tmp_path / "cut.mp4").write_bytes(whole[:kept])
        with pytest.raises(BrokenVideoError):
            read_header(tmp_path / "cut.mp4")
    (tmp_path / "text.mp4").write_bytes(b"no video at all, but some text of a few words")
    with pytest.raises(BrokenVideoError):
        read_header(tmp_path / "text.mp4")
