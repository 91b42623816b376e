"""A copy of the project's pipeline with tiny parameters, in a folder of its own."""

from __future__ import annotations

import importlib
import itertools
import os
import shutil
import subprocess
import sys
from pathlib import Path

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


def make(folder: Path, params: str | None = None) -> Path:
    """A DVC project in ``folder`` with everything that its stages depend on."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("lfr", "pipeline"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in ("dvc.yaml", ".dvcignore"):
        shutil.copy(ROOT / name, folder / name)
    tiny = (ROOT / "tests" / "tiny_params.yaml").read_text()
    (folder / "params.yaml").write_text(tiny if params is None else params)
    run(folder, "dvc", "init", "--no-scm", "--quiet")
    return folder


def run_stages(folder: Path) -> Path:
    """All stages in ``folder`` without DVC, in this process: each is started but once."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "tests" / "tiny_params.yaml", folder / "params.yaml")
    params = read_yaml(folder / "params.yaml")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.delenv("RAY_ADDRESS", raising=False)
        patch.setattr("os.cpu_count", lambda: 1)  # jobs run here
        datasets = itertools.product(params["robots"], params["tasks"])
        for robot, task in datasets:
            for stage in ("record", "pack"):
                _stage(stage, "--robot", robot, "--task", task)
        for transfer in params["transfers"]:
            _stage("skills", "--transfer", transfer)
            _stage("mapping", "--transfer", transfer)
            for method in params["methods"]:
                _stage("transfer", "--transfer", transfer, "--method", method)
                _stage("evaluate", "--transfer", transfer, "--method", method)
        _stage("report")
    return folder


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
