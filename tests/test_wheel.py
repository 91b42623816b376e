"""The wheel, in an environment of its own without the repository, torch or robosuite."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
UV = shutil.which("uv") or next(iter((ROOT / ".uv").glob("bin/uv")), None)

pytestmark = [pytest.mark.slow, pytest.mark.skipif(UV is None, reason="no uv")]


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`lfr[view]`, installed from the wheel that the source distribution makes."""
    folder = tmp_path_factory.mktemp("wheel")
    _run(folder, UV, "build", "--quiet", "--out-dir", folder / "dist", ROOT)
    (wheel,) = (folder / "dist").glob("*.whl")
    assert len(list((folder / "dist").glob("*.tar.gz"))) == 1
    _run(folder, UV, "venv", "--quiet", "--python", sys.executable, "env")
    python = folder / "env/bin/python"
    _run(folder, UV, "pip", "install", "--quiet", "--python", python, f"{wheel}[view]")
    return folder


def test_datasets_are_looked_at_without_what_learns(environment: Path) -> None:
    from tests.external import made_up

    made_up.write_both(environment / "data", episodes=2)
    dataset = environment / "data/crane"
    listed = json.loads(_run(environment, UV, "pip", "list", "--format", "json", "--python",
                             "env/bin/python"))  # fmt: skip
    there = {one["name"] for one in listed}
    assert {"lfr", "rerun-sdk"} <= there
    assert not {"torch", "robosuite", "lerobot", "mujoco", "dvc", "ray"} & there
    lfr = environment / "env/bin/lfr"
    assert "look      lfr view" in _run(environment, lfr, "--help")
    assert "no errors" in _run(environment, lfr, "verify", dataset)
    assert "vx: a change or speed" in _run(environment, lfr, "columns", dataset)
    _run(environment, lfr, "diff", dataset, dataset)
    _run(environment, lfr, "view", dataset, "--save", "episode.rrd")
    assert (environment / "episode.rrd").stat().st_size > 10_000
    told = subprocess.run([lfr, "export", "a", "b"], cwd=environment, text=True,
                          capture_output=True, env=_bare())  # fmt: skip
    assert "lerobot is not installed; install lfr with its extra `pipeline`" in told.stderr


def _run(folder: Path, *command: object) -> str:
    done = subprocess.run(
        [str(word) for word in command], cwd=folder, text=True, capture_output=True, env=_bare()
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def _bare() -> dict[str, str]:
    own = ("PYTHONPATH", "VIRTUAL_ENV")
    return {key: value for key, value in os.environ.items() if key not in own}
