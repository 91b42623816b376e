"""Encoding leaves the process's priority as it was, as root and as anybody else."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lfr.data.priority import THREADS, kept_priority

pytestmark = pytest.mark.skipif(not THREADS.is_dir(), reason="Linux alone has these policies")

# In a process of its own: in this one somebody else may have encoded before.
ENCODE = """
import io, os, subprocess, sys
from pathlib import Path
import numpy as np
from PIL import Image
from lfr.data.priority import THREADS
from lfr.data.video import VideoWriter

picture = io.BytesIO()
Image.fromarray(np.zeros((64, 64, 3), np.uint8)).save(picture, "JPEG")
path = "{chunk_index}-{file_index}.mp4"
writer = VideoWriter(Path(sys.argv[1]), "observation.images.top", path, 20)
writer.write([picture.getvalue()] * 3)
print(*sorted({os.sched_getscheduler(int(thread.name)) for thread in THREADS.iterdir()}))
ask = "import os; print(os.sched_getscheduler(0))"
subprocess.run([sys.executable, "-c", ask], check=True)
"""


def test_a_video_is_written_without_real_time_threads(tmp_path: Path) -> None:
    def as_anybody() -> None:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))

    command = [sys.executable, "-c", ENCODE, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True,
                          preexec_fn=as_anybody)  # fmt: skip
    inside, child = done.stdout.split("\n")[:2]
    assert inside == str(os.SCHED_OTHER), done.stderr
    assert child == str(os.SCHED_OTHER)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may become real-time")
@pytest.mark.parametrize("before", [os.SCHED_OTHER, os.SCHED_FIFO])
def test_what_becomes_real_time_inside_is_put_back(before: int) -> None:
    here = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, before, os.sched_param(int(before == os.SCHED_FIFO)))
        with kept_priority():
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(2))
        assert os.sched_getscheduler(0) == before
    except PermissionError:
        pytest.skip("not even root may, in this container")
    finally:
        os.sched_setscheduler(0, *here)
