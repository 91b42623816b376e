"""The same jobs on a local Ray node: the same results, errors and second attempts."""

import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from lfr.errors import LfrError
from lfr.jobs import run_jobs

from . import made_up_jobs as jobs

ROOT = Path(__file__).parent.parent

PROGRAM = """
import json, sys
from pathlib import Path
from types import SimpleNamespace
from lfr.errors import LfrError
from lfr.jobs import run_jobs
from lfr.jobs.cluster import run_on_ray
from lfr.jobs.order import Order
from tests import made_up_jobs as jobs

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    squares = [jobs.Spec(number, str(folder)) for number in (3, 1)]
    more = [jobs.Spec(number, str(folder)) for number in (3, 2, 1)]
    found = {"squares": run_jobs(jobs.square, squares, work=folder / "work")}
    found["more"] = run_jobs(jobs.square, more, work=folder / "work")
    chained = [jobs.Spec(number, str(folder)) for number in (1, 0)]
    found["chained"] = run_jobs(jobs.reads_or_writes, chained, after={0: 1})
    found["numerical"] = run_jobs(jobs.numerical, [0])
    found["died"] = run_jobs(jobs.dies_once, more)
    found["heard"] = []
    heard = SimpleNamespace(
        report=lambda index, fraction: found["heard"].append(fraction),
        finish=lambda index, result: found["heard"].append(result),
    )
    run_on_ray(jobs.reporting, {0: 8}, Order([0], {}), heard)
    try:
        run_jobs(jobs.unknown, ["x"])
    except LfrError as error:
        found["mistake"] = str(error)
    try:
        run_jobs(jobs.faulty, [1])
    except RuntimeError as error:
        found["fault"] = str(error)
    (folder / "found.json").write_text(json.dumps(found))  # Ray writes to stdout, too
"""


@pytest.fixture(scope="module")
def found(ray_address: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the program finds on the cluster."""
    folder = tmp_path_factory.mktemp("jobs")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(folder)],
        cwd=ROOT,
        env={**os.environ, "RAY_ADDRESS": ray_address},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    ran = sorted((folder / "ran").read_text().split())
    return {**json.loads((folder / "found.json").read_text()), "ran": ran}


@pytest.mark.slow
def test_the_same_results_and_none_twice(found: dict[str, Any]) -> None:
    assert found["squares"] == run_jobs(jobs.square, [jobs.Spec(3), jobs.Spec(1)])
    assert [result["square"] for result in found["more"]] == [9, 4, 1]
    assert found["chained"] == [1, 0]
    assert found["ran"] == ["1", "2", "3"]
    assert found["numerical"] == run_jobs(jobs.numerical, [0], workers=1)


@pytest.mark.slow
def test_a_killed_worker_costs_one_attempt(found: dict[str, Any]) -> None:
    assert found["died"] == [3, 2, 1]


@pytest.mark.slow
def test_reports_arrive(found: dict[str, Any]) -> None:
    *fractions, result = found["heard"]
    assert result == 8
    assert any(0 < fraction < 1 for fraction in fractions)
    assert fractions == sorted(fractions)


@pytest.mark.slow
def test_errors_come_through(found: dict[str, Any]) -> None:
    assert found["mistake"] == "unknown robot 'x'; valid: panda"
    assert "in faulty" in found["fault"]
    assert "ZeroDivisionError" in found["fault"]


def test_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))  # bound and not listening: connections are refused
        address = f"127.0.0.1:{closed.getsockname()[1]}"
        monkeypatch.setenv("RAY_ADDRESS", address)
        with pytest.raises(LfrError, match=f"no Ray cluster at RAY_ADDRESS={address}: .*refused"):
            run_jobs(jobs.square, [jobs.Spec(1)])
