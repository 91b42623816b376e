"""How programs end: one line for a mistake, a traceback for a fault, nothing left behind."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lfr.errors import UnknownNameError
from lfr.program import run_program, run_stage
from lfr.robots import robot as robot_named
from tests.processes import ended


def record(robot: str, video: str = "yes") -> None:
    """Record demonstrations."""
    robot_named(robot)
    print(robot, video)


def test_the_keys_of_a_stage_are_the_parameters_of_its_function(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run_stage(record, ["--robot", "panda"]) == 0
    assert run_stage(record, ["--robot", "sawyer", "--video", "no"]) == 0
    assert capsys.readouterr().out == "panda yes\nsawyer no\n"


def test_a_mistake_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_stage(record, ["--robot", "pando"]) == 2
    printed = capsys.readouterr()
    valid = "panda, sawyer, ur5e, iiwa, kinova3, xarm7, jaco"
    assert printed.err == f"lfr: error: unknown robot 'pando'; valid: {valid}\n"
    assert printed.out == ""


@pytest.mark.parametrize("arguments", [[], ["--robot", "panda", "--task", "lift"]])
def test_keys_missing_or_too_many(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        run_stage(record, arguments)
    assert caught.value.code == 2
    assert "--robot" in capsys.readouterr().err


def test_a_full_disk_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    def fill() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "data/a.mcap")

    assert run_program(fill) == 2
    assert capsys.readouterr().err == "lfr: error: No space left on device: data/a.mcap\n"


def test_a_library_of_an_extra_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    for name, extra in (("torch.nn", "pipeline"), ("rerun", "view"), ("ray", "cluster")):
        assert run_program(lambda name=name: missing(name)) == 2
        said = f"{name.partition('.')[0]} is not installed; install lfr with its extra `{extra}`"
        assert capsys.readouterr().err == f"lfr: error: {said}\n"
    with pytest.raises(ModuleNotFoundError):  # a fault of ours
        run_program(lambda: missing("lfr.nowhere"))


def test_a_fault_keeps_its_traceback() -> None:
    def fault() -> None:
        raise KeyError("cube")

    with pytest.raises(KeyError):
        run_program(fault)


def test_stopped_by_hand(capsys: pytest.CaptureFixture[str]) -> None:
    def stop() -> None:
        raise KeyboardInterrupt

    assert run_program(stop) == 130
    assert capsys.readouterr().err == "lfr: stopped\n"


def test_a_program_may_answer_with_an_exit_code():
    assert run_program(lambda: None) == 0
    assert run_program(lambda: 1) == 1


def test_unknown_name_error_is_a_mistake() -> None:
    assert UnknownNameError.exit_code == 2


STAGE = """
import sys, time
from pathlib import Path
from lfr.program import run_stage

def main(mark: str) -> None:
    Path(mark).touch()
    time.sleep(60)
    Path(mark).unlink()

if __name__ == "__main__":
    sys.exit(run_stage(main))
"""


def test_a_stage_ends_with_the_dvc_that_started_it(tmp_path: Path) -> None:
    stage, mark = tmp_path / "stage.py", tmp_path / "mark"
    stage.write_text(STAGE)
    parent = subprocess.Popen(
        [
            sys.executable,
            "-c",
            "import subprocess, sys; p = subprocess.Popen(sys.argv[1:]); print(p.pid); p.wait()",
            *(sys.executable, str(stage), "--mark", str(mark)),
        ],
        env={**os.environ, "DVC_STAGE": "stage", "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert parent.stdout is not None
    pid = int(parent.stdout.readline())
    deadline = time.monotonic() + 30
    while not mark.exists():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    parent.send_signal(signal.SIGKILL)
    parent.communicate()
    while not ended(pid):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert mark.exists()  # it was ended, it did not finish
