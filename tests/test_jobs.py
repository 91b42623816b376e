"""Jobs: the same results wherever they run, nothing finished is run again, deaths are survived."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch
from tqdm import tqdm

from lfr.artifacts import fingerprint
from lfr.errors import DataError, LfrError, UnknownNameError
from lfr.jobs import memory, peak_memory, report, run_jobs
from lfr.jobs.here import run_here
from lfr.jobs.order import Order
from lfr.jobs.pool import run_in_pool
from lfr.jobs.results import Results
from lfr.progress import progress

from . import made_up_jobs as jobs


def ran(folder: Path) -> list[int]:
    return sorted(int(line) for line in (folder / "ran").read_text().split())


@pytest.mark.parametrize("workers", [1, 2])
def test_results_in_the_order_of_the_specs(workers: int) -> None:
    results = run_jobs(jobs.square, [jobs.Spec(number) for number in (3, 1, 2)], workers=workers)
    assert results == [{"square": n * n, "pair": [n, 0.1]} for n in (3, 1, 2)]
    assert run_jobs(jobs.square, [], workers=workers) == []


@pytest.mark.parametrize("workers", [1, 3])
def test_a_job_starts_when_the_one_that_it_needs_is_done(workers: int, tmp_path: Path) -> None:
    """Three readers of what the last job writes, slowly, and one that needs nobody."""
    specs = [jobs.Spec(number, str(tmp_path)) for number in (1, 2, 3, 4, 0)]
    after = {0: 4, 1: 4, 2: 4}
    assert run_jobs(jobs.reads_or_writes, specs, after=after, workers=workers) == [1, 2, 3, -1, 0]


def test_a_job_that_is_kept_holds_nobody_back(tmp_path: Path) -> None:
    specs = [jobs.Spec(0, str(tmp_path)), jobs.Spec(1, str(tmp_path))]
    work = tmp_path / "work"
    run_jobs(jobs.reads_or_writes, specs[:1], workers=1, work=work)
    assert run_jobs(jobs.reads_or_writes, specs, after={1: 0}, workers=2, work=work) == [0, 1]


def test_a_job_that_died_is_waited_for(tmp_path: Path) -> None:
    specs = [jobs.Spec(number, str(tmp_path)) for number in (1, 2, 3)]
    found = run_jobs(jobs.dies_once, specs, after={1: 0, 2: 0}, workers=2)
    assert found == [1, 2, 3]


def test_the_same_bits_on_one_thread_wherever_it_runs() -> None:
    before = torch.get_num_threads()
    here = run_jobs(jobs.numerical, [0], workers=1)
    there: dict[int, list[float]] = {}
    with progress(1) as bar:  # one worker, so that torch is loaded once
        run_in_pool(jobs.numerical, {0: 0}, Order([0], {}), 1, Results(bar, there.__setitem__))
    assert there == {0: here[0]}
    assert here[0][1] == 1
    assert torch.get_num_threads() == before


def test_the_peak_memory_of_workers_is_known_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "_workers", 0)
    peaks = run_jobs(jobs.hungry, [50, 300], workers=2)
    assert peak_memory() >= max(peaks) > 300 * 2**20
    assert memory._workers == max(peaks)


@pytest.mark.parametrize("workers", [1, 2])
def test_finished_jobs_are_not_run_again(tmp_path: Path, workers: int) -> None:
    work = tmp_path / "work"
    first = [jobs.Spec(number, str(tmp_path)) for number in (1, 2)]
    more = [jobs.Spec(number, str(tmp_path)) for number in (3, 1, 2)]
    run_jobs(jobs.square, first, workers=workers, work=work)
    results = run_jobs(jobs.square, more, workers=workers, work=work)
    assert [result["square"] for result in results] == [9, 1, 4]
    assert ran(tmp_path) == [1, 2, 3]
    assert run_jobs(jobs.square, more, workers=1) == results  # fresh ones and kept ones are equal


def test_what_is_kept_can_be_read(tmp_path: Path) -> None:
    run_jobs(jobs.square, [jobs.Spec(2)], work=tmp_path)
    (file,) = tmp_path.iterdir()
    assert file.stem == fingerprint("tests.made_up_jobs.square", {"number": 2, "folder": ""})
    assert json.loads(file.read_text())["result"]["square"] == 4


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_of_the_user_comes_through_as_itself(workers: int) -> None:
    with pytest.raises(UnknownNameError, match=r"^unknown robot 'x'; valid: panda$") as caught:
        run_jobs(jobs.unknown, ["x", "x"], workers=workers)
    assert caught.value.valid == ("panda",)
    with pytest.raises(DataError, match=r"^cut off: a.mcap, episode 3$") as damage:
        run_jobs(jobs.damaged, ["a.mcap", "a.mcap"], workers=workers)
    assert damage.value.episode == 3


def test_a_fault_comes_through_with_its_traceback() -> None:
    with pytest.raises(ZeroDivisionError):
        run_jobs(jobs.faulty, [1, 2], workers=1)
    with pytest.raises(RuntimeError, match=r"(?s)job \d failed.*in faulty.*ZeroDivisionError"):
        run_jobs(jobs.faulty, [1, 2], workers=2)


def test_a_killed_worker_costs_one_attempt(tmp_path: Path) -> None:
    specs = [jobs.Spec(number, str(tmp_path)) for number in range(5)]
    assert run_jobs(jobs.dies_once, specs, workers=2) == [0, 1, 2, 3, 4]
    assert {path.name for path in tmp_path.iterdir()} == {"mark-1", "mark-3"}


def test_a_job_that_always_kills_its_worker() -> None:
    with pytest.raises(LfrError, match=r"the process of job 7 died 2 times \(SIGKILL\)"):
        run_jobs(jobs.dies, [7, 7], workers=2)


@pytest.mark.parametrize("backend", ["here", "pool"])
def test_the_bar_shows_the_sum_of_what_jobs_report(backend: str) -> None:
    seen: list[float] = []

    class Bar(tqdm):
        def update(self, n: float | None = 1) -> bool | None:
            seen.append(self.n)
            return super().update(n)

    results = Results(Bar(total=2, file=io.StringIO()), lambda index, result: None)
    if backend == "here":
        run_here(jobs.reporting, {0: 2, 1: 2}, Order([0, 1], {}), results)
    else:
        run_in_pool(jobs.reporting, {0: 2, 1: 2}, Order([0, 1], {}), 2, results)
    assert 0.5 in seen
    assert seen[-1] == 2
    assert max(seen) == 2


def test_report_outside_a_job_does_nothing() -> None:
    report(1, 2)


PROGRAM = """
import signal, sys, time
from pathlib import Path
from lfr.jobs import run_jobs

def slow(number):
    (Path(sys.argv[1]) / f"started-{number}").touch()
    time.sleep(0 if number < 2 else 60)
    return number

if __name__ == "__main__":
    # A shell's background job, such as a test run may be, has Ctrl-C switched off.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    run_jobs(slow, [0, 1, 2, 3], workers=2, work=Path(sys.argv[1]) / "work")
"""


def start_program(folder: Path) -> subprocess.Popen[str]:
    (folder / "program.py").write_text(PROGRAM)
    process = subprocess.Popen(
        [sys.executable, str(folder / "program.py"), str(folder)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60
    while not (folder / "started-3").exists() or not (folder / "started-2").exists():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return process


def processes_of(folder: Path) -> list[str]:
    lines = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            found = b"LFR_TEST_FOLDER=" + str(folder).encode() in path.read_bytes()
        except OSError:
            continue
        if found:
            lines.append(path.parent.name)
    return lines


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs Linux's /proc")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL])
def test_ended_from_outside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: signal.Signals
) -> None:
    """It stops at once, keeps what was finished, and leaves no process behind."""
    monkeypatch.setenv("LFR_TEST_FOLDER", str(tmp_path))
    process = start_program(tmp_path)
    if ending == signal.SIGINT:  # Ctrl-C in a terminal goes to the whole group
        os.killpg(process.pid, ending)
    else:
        process.kill()
    process.communicate(timeout=30)
    deadline = time.monotonic() + 30
    while processes_of(tmp_path):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    kept = [json.loads(file.read_text()) for file in (tmp_path / "work").iterdir()]
    assert sorted(job["result"] for job in kept) == [0, 1]
    assert all(job["function"] == "__main__.slow" for job in kept)
