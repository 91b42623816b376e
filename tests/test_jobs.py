"""Jobs: the same results wherever they run, nothing finished is run again, deaths are survived."""

import io
import json
import os
import platform
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import pytest
import torch
from tqdm import tqdm

from lfr.artifacts import fingerprint
from lfr.errors import DataError, LfrError, UnknownNameError
from lfr.jobs import Job, memory, peak_memory, report, run_jobs
from lfr.jobs.here import run_here
from lfr.jobs.order import Order
from lfr.jobs.pool import run_in_pool
from lfr.jobs.results import Results
from lfr.progress import progress

from . import made_up_jobs as jobs


def each(function: Callable[[Any], Any], specs: Iterable[Any], *needs: Job) -> list[Job]:
    return [Job(function, spec, needs) for spec in specs]


def ran(folder: Path) -> list[int]:
    return sorted(int(line) for line in (folder / "ran").read_text().split())


@pytest.mark.parametrize("workers", [1, 2])
def test_results_by_job_in_their_order(workers: int) -> None:
    todo = each(jobs.square, [jobs.Spec(number) for number in (3, 1, 2)])
    found = run_jobs(todo, workers=workers)
    assert list(found) == todo
    assert list(found.values()) == [{"square": n * n, "pair": [n, 0.1]} for n in (3, 1, 2)]
    assert run_jobs([], workers=workers) == {}


@pytest.mark.parametrize("workers", [1, 2])
def test_jobs_of_several_functions_in_one_run(workers: int) -> None:
    """Two jobs alike are two, and one that is named twice is one."""
    alike = each(jobs.square, [jobs.Spec(2), jobs.Spec(2)])
    other = Job(jobs.reporting, 1)
    found = run_jobs([other, *alike, other], workers=workers)
    assert found == {other: 1, **{job: {"square": 4, "pair": [2, 0.1]} for job in alike}}
    assert len(found) == 3


@pytest.mark.parametrize("workers", [1, 3])
def test_a_job_starts_when_the_one_that_it_needs_is_done(workers: int, tmp_path: Path) -> None:
    """Three readers of what the last job writes, slowly, and one that needs nobody."""
    writer = Job(jobs.writes, str(tmp_path))
    readers = each(jobs.reads, [jobs.Spec(number, str(tmp_path)) for number in (1, 2, 3)], writer)
    early = Job(jobs.reads, jobs.Spec(4, str(tmp_path)))
    found = run_jobs([*readers, early, writer], workers=workers)
    assert list(found.values()) == [1, 2, 3, -1, 0]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_job_may_need_several(workers: int, tmp_path: Path) -> None:
    """In a diamond the last one starts when both of the middle have read what the first wrote."""
    first = Job(jobs.writes, str(tmp_path))
    middle = each(jobs.reads, [jobs.Spec(number, str(tmp_path)) for number in (1, 2)], first)
    last = Job(jobs.clears, str(tmp_path), tuple(middle))
    found = run_jobs([last, *middle, first], workers=workers)
    assert list(found.values()) == [0, 1, 2, 0]


def test_a_need_that_is_not_in_the_run_is_an_error(tmp_path: Path) -> None:
    writer = Job(jobs.writes, str(tmp_path))
    reader = Job(jobs.reads, jobs.Spec(1, str(tmp_path)), (writer,))
    early = Job(jobs.square, jobs.Spec(1, str(tmp_path)))
    with pytest.raises(ValueError, match=r"reads\(Spec.* needs .*writes\(.*not in this run$"):
        run_jobs([early, reader])
    assert not list(tmp_path.iterdir())  # nothing has run


def test_jobs_cannot_wait_for_each_other() -> None:
    first = Job(jobs.square, jobs.Spec(1))
    with pytest.raises(FrozenInstanceError):
        first.needs = (Job(jobs.square, jobs.Spec(2), (first,)),)  # pyright: ignore


def test_a_job_that_is_kept_holds_nobody_back(tmp_path: Path) -> None:
    writer = Job(jobs.writes, str(tmp_path))
    reader = Job(jobs.reads, jobs.Spec(1, str(tmp_path)), (writer,))
    work = tmp_path / "work"
    run_jobs([writer], workers=1, work=work)
    assert run_jobs([reader, writer], workers=2, work=work) == {writer: 0, reader: 1}


def test_a_job_that_died_is_waited_for(tmp_path: Path) -> None:
    first, *others = (jobs.Spec(number, str(tmp_path)) for number in (1, 2, 3))
    job = Job(jobs.dies_once, first)
    found = run_jobs([job, *each(jobs.dies_once, others, job)], workers=2)
    assert list(found.values()) == [1, 2, 3]


def test_the_same_bits_on_one_thread_wherever_it_runs() -> None:
    before = torch.get_num_threads()
    job = Job(jobs.numerical, 0)
    here = run_jobs([job], workers=1)
    there: dict[Job, list[float]] = {}
    with progress(1) as bar:  # one worker, so that torch is loaded once
        run_in_pool(Order([job]), 1, Results(bar, there.__setitem__))
    assert there == here
    assert here[job][1] == 1
    assert torch.get_num_threads() == before


def test_the_peak_memory_of_workers_is_known_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "_workers", 0)
    peaks = run_jobs(each(jobs.hungry, [50, 300]), workers=2).values()
    assert peak_memory() >= max(peaks) > 300 * 2**20
    assert memory._workers == max(peaks)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the C library is not glibc")
def test_what_a_job_frees_is_kept_for_it(tmp_path: Path) -> None:
    program = "from tests.made_up_jobs import faulting; print(faulting(20))"
    plain = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    for workers in (1, 2):
        (here, *_) = run_jobs(each(jobs.faulting, [20, 20]), workers=workers).values()
        assert here < 0.1 * int(plain.stdout)


@pytest.mark.parametrize("workers", [1, 2])
def test_finished_jobs_are_not_run_again(tmp_path: Path, workers: int) -> None:
    work = tmp_path / "work"
    first, more = (
        each(jobs.square, [jobs.Spec(number, str(tmp_path)) for number in numbers])
        for numbers in ((1, 2), (3, 1, 2))
    )
    run_jobs(first, workers=workers, work=work)
    results = run_jobs(more, workers=workers, work=work)
    assert [result["square"] for result in results.values()] == [9, 1, 4]
    assert ran(tmp_path) == [1, 2, 3]
    assert run_jobs(more, workers=1) == results  # fresh ones and kept ones are equal


def test_what_is_kept_can_be_read(tmp_path: Path) -> None:
    run_jobs([Job(jobs.square, jobs.Spec(2))], work=tmp_path)
    (file,) = tmp_path.iterdir()
    assert file.stem == fingerprint("tests.made_up_jobs.square", {"number": 2, "folder": ""})
    assert json.loads(file.read_text())["result"]["square"] == 4


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_of_the_user_comes_through_as_itself(workers: int) -> None:
    with pytest.raises(UnknownNameError, match=r"^unknown robot 'x'; valid: panda$") as caught:
        run_jobs(each(jobs.unknown, ["x", "x"]), workers=workers)
    assert caught.value.valid == ("panda",)
    with pytest.raises(DataError, match=r"^cut off: a.mcap, episode 3$") as damage:
        run_jobs(each(jobs.damaged, ["a.mcap", "a.mcap"]), workers=workers)
    assert damage.value.episode == 3


def test_a_fault_comes_through_with_its_traceback() -> None:
    with pytest.raises(ZeroDivisionError):
        run_jobs(each(jobs.faulty, [1, 2]), workers=1)
    with pytest.raises(RuntimeError, match=r"(?s)job \d failed.*in faulty.*ZeroDivisionError"):
        run_jobs(each(jobs.faulty, [1, 2]), workers=2)


def test_a_killed_worker_costs_one_attempt(tmp_path: Path) -> None:
    todo = each(jobs.dies_once, [jobs.Spec(number, str(tmp_path)) for number in range(5)])
    assert list(run_jobs(todo, workers=2).values()) == [0, 1, 2, 3, 4]
    assert {path.name for path in tmp_path.iterdir()} == {"mark-1", "mark-3"}


def test_a_job_that_always_kills_its_worker() -> None:
    with pytest.raises(LfrError, match=r"the process of job 7 died 2 times \(SIGKILL\)"):
        run_jobs(each(jobs.dies, [7, 7]), workers=2)


@pytest.mark.parametrize("backend", ["here", "pool"])
def test_the_bar_shows_the_sum_of_what_jobs_report(backend: str) -> None:
    seen: list[float] = []

    class Bar(tqdm):
        def update(self, n: float | None = 1) -> bool | None:
            seen.append(self.n)
            return super().update(n)

    results = Results(Bar(total=2, file=io.StringIO()), lambda job, result: None)
    order = Order(each(jobs.reporting, [2, 2]))
    if backend == "here":
        run_here(order, results)
    else:
        run_in_pool(order, 2, results)
    assert 0.5 in seen
    assert seen[-1] == 2
    assert max(seen) == 2


def test_report_outside_a_job_does_nothing() -> None:
    report(1, 2)


PROGRAM = """
import signal, sys, time
from pathlib import Path
from lfr.jobs import Job, run_jobs

def slow(number):
    (Path(sys.argv[1]) / f"started-{number}").touch()
    time.sleep(0 if number < 2 else 60)
    return number

if __name__ == "__main__":
    # A shell's background job, such as a test run may be, has Ctrl-C switched off.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    jobs = [Job(slow, number) for number in range(4)]
    run_jobs(jobs, workers=2, work=Path(sys.argv[1]) / "work")
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
