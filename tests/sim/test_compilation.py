"""The kernel's first start: of several processes one compiles, the others wait for what it kept."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import lfr

START = """
from lfr.sim.simulation import Simulation
print(Simulation("panda", "lift").observation().sum())
"""


@pytest.mark.slow
def test_two_processes_compile_the_kernel_once(tmp_path: Path) -> None:
    """All of it: what is called after the first reset, too."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(lfr.__file__).parent, tmp_path / "lfr", ignore=ignored)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": ""}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", START], cwd=tmp_path, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )
        for _ in range(2)
    ]  # fmt: skip
    ends = [process.communicate(timeout=500) for process in running]
    assert [process.returncode for process in running] == [0, 0]
    assert ends[0][0] == ends[1][0]
    assert sorted("compiling" in told for _, told in ends) == [False, True]
    kept = {path.name: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nbc")}
    again = subprocess.run(
        [sys.executable, "-c", START], cwd=tmp_path, env=environment, text=True,
        capture_output=True, check=True, timeout=500,
    )  # fmt: skip
    assert "compiling" not in again.stderr
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nbc")} == kept
