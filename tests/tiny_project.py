"""A copy of one of the project's pipelines with tiny parameters, in a folder of its own."""

from __future__ import annotations

import contextlib
import importlib
import itertools
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from lfr.params import read_yaml
from lfr.program import run_stage

ROOT = Path(__file__).parent.parent
# DVC looks at the copy's sources; Python takes the project's own, whose kernel is compiled already.
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONPATH": str(ROOT),
    "PYTHONSAFEPATH": "1",
    "PYTHONDONTWRITEBYTECODE": "",  # a process that compiles robosuite again takes seconds longer
    "DVC_NO_ANALYTICS": "1",
}

# What differs between two runs of the same thing. A log names its git revision, and a dataset its
# logs by hash, so the size of a compressed table may differ by a byte.
PASSING = ("seconds", "peak_memory", "provenance", "revisions", "bytes")


def make(folder: Path, params: str | None = None, pipeline: str = "dvc.yaml") -> Path:
    """A DVC project in ``folder`` with all the code that the stages of ``pipeline`` depend on."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("lfr", "pipeline"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in (pipeline, ".dvcignore"):
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    tiny = (ROOT / "tests" / "tiny_params.yaml").read_text()
    (folder / "params.yaml").write_text(tiny if params is None else params)
    run(folder, "dvc", "init", "--no-scm", "--quiet")
    return folder


def run_stages(folder: Path) -> Path:
    """All stages in ``folder`` without DVC, in this process: each is started but once."""
    with _within(folder) as params:
        _demonstrate(params)
        for robot in params["robots"]:
            _stage("skills", "--robot", robot)
        for transfer in params["transfers"]:
            _stage("mapping", "--transfer", transfer)
            for method in params["methods"]:
                _stage("transfer", "--transfer", transfer, "--method", method)
                _stage("recordings", "--transfer", transfer, "--method", method)
                _stage("evaluate", "--transfer", transfer, "--method", method)
        _stage("report")
    return folder


def run_demonstrations(folder: Path) -> Path:
    """The first stages alone, in the same way: data/lerobot in ``folder``."""
    with _within(folder) as params:
        _demonstrate(params)
    return folder


@contextlib.contextmanager
def _within(folder: Path) -> Iterator[dict[str, Any]]:
    """Inside ``folder``, whose tiny parameters are given, jobs run in this process."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "tests" / "tiny_params.yaml", folder / "params.yaml")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.delenv("RAY_ADDRESS", raising=False)
        patch.setattr("os.cpu_count", lambda: 1)
        yield read_yaml(folder / "params.yaml")


def _demonstrate(params: dict[str, Any]) -> None:
    for robot, task in itertools.product(params["robots"], params["tasks"]):
        for stage in ("record", "pack"):
            _stage(stage, "--robot", robot, "--task", task)


def _stage(name: str, *arguments: str) -> None:
    main = importlib.import_module(f"pipeline.{name}").main
    assert run_stage(main, arguments) == 0, f"{name} {arguments}"


def run(
    folder: Path, *command: str, expect: int = 0, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a command there; its output is in the message if it ends in another way."""
    environment = {**ENVIRONMENT, **environment}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == expect, (
        f"{command} {done.returncode}\n{done.stdout[-4000:]}\n{done.stderr[-6000:]}"
    )
    return done


def kill_when(folder: Path, pattern: str, *command: str) -> None:
    """Run a command there and kill it with all its processes once a file like ``pattern`` is."""
    running = subprocess.Popen(
        command, cwd=folder, env=ENVIRONMENT, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    deadline = time.monotonic() + 300
    while not any(folder.glob(pattern)):
        assert running.poll() is None, f"{command} ended before {pattern} was there"
        assert time.monotonic() < deadline
        time.sleep(0.01)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    time.sleep(2)  # what outlived it ends by itself


def finished(folder: Path) -> list[Path]:
    """Results that `run_jobs` keeps: <16 digits>.json right under a fingerprint."""
    return sorted(p for p in (folder / "work").glob("*/*/*/*.json") if len(p.stem) == 16)


def lasting(content: Any) -> Any:
    """The content of a JSON file without what differs between two runs of the same thing."""
    if isinstance(content, dict):
        return {key: lasting(item) for key, item in content.items() if key not in PASSING}
    return [lasting(item) for item in content] if isinstance(content, list) else content
