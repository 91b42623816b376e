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
from lfr.jobs import Job, run_jobs

from . import made_up_jobs as jobs

ROOT = Path(__file__).parent.parent

PROGRAM = """
import json, sys
from pathlib import Path
from types import SimpleNamespace
from lfr.errors import LfrError
from lfr.jobs import Job, run_jobs
from lfr.jobs.cluster import run_on_ray
from lfr.jobs.order import Order
from tests import made_up_jobs as jobs

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    work = folder / "work"
    squares = [Job(jobs.square, jobs.Spec(number, str(folder))) for number in (3, 1)]
    more = [jobs.Spec(number, str(folder)) for number in (3, 2, 1)]
    found = {"squares": list(run_jobs(squares, work=work).values())}
    found["more"] = list(run_jobs([Job(jobs.square, spec) for spec in more], work=work).values())
    writer = Job(jobs.writes, str(folder))
    reader = Job(jobs.reads, jobs.Spec(1, str(folder)), (writer,))
    found["chained"] = list(run_jobs([reader, writer]).values())
    found["numerical"] = list(run_jobs([Job(jobs.numerical, 0)]).values())
    found["died"] = list(run_jobs([Job(jobs.dies_once, spec) for spec in more]).values())
    found["heard"] = []
    heard = SimpleNamespace(
        report=lambda job, fraction: found["heard"].append(fraction),
        finish=lambda job, result: found["heard"].append(result),
    )
    run_on_ray(Order([Job(jobs.reporting, 8)]), heard)
    try:
        run_jobs([Job(jobs.unknown, "x")])
    except LfrError as error:
        found["mistake"] = str(error)
    try:
        run_jobs([Job(jobs.faulty, 1)])
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
    here = run_jobs([Job(jobs.square, jobs.Spec(number)) for number in (3, 1)])
    assert found["squares"] == list(here.values())
    assert [result["square"] for result in found["more"]] == [9, 4, 1]
    assert found["chained"] == [1, 0]
    assert found["ran"] == ["1", "2", "3"]
    assert found["numerical"] == list(run_jobs([Job(jobs.numerical, 0)], workers=1).values())


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
            run_jobs([Job(jobs.square, jobs.Spec(1))])
