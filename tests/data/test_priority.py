"""Encoding leaves the process's priority as it was, as root and as anybody else."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lfr.data.priority import THREADS, kept_priority
from lfr.data.video import VideoWriter

pytestmark = pytest.mark.skipif(not THREADS.is_dir(), reason="Linux alone has these policies")
ASK = "import os; print(os.sched_getscheduler(0))"


def policies() -> set[int]:
    return {os.sched_getscheduler(int(entry.name)) for entry in THREADS.iterdir()}


def test_a_video_is_written_without_real_time_threads(tmp_path: Path) -> None:
    before = os.sched_getscheduler(0)
    picture = io.BytesIO()
    Image.fromarray(np.zeros((64, 64, 3), np.uint8)).save(picture, "JPEG")
    path = "{chunk_index}-{file_index}.mp4"
    writer = VideoWriter(tmp_path, "observation.images.top", path, 20)
    writer.write([picture.getvalue()] * 3)
    assert os.sched_getscheduler(0) == before
    assert os.SCHED_FIFO not in policies()
    child = subprocess.run([sys.executable, "-c", ASK], capture_output=True, text=True, check=True)
    assert int(child.stdout) == before


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may become real-time")
def test_what_becomes_real_time_inside_is_put_back() -> None:
    before = os.sched_getscheduler(0)
    try:
        with kept_priority():
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))
    except PermissionError:
        pytest.skip("not even root may, in this container")
    assert os.sched_getscheduler(0) == before
