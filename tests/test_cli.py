"""The command `lfr`, called as a user calls it."""

import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("torch", "numpy", "rerun", "lerobot", "robosuite", "mujoco", "pandas", "ray")


def lfr(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [str(Path(sys.executable).with_name("lfr")), *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_help_names_the_commands(tmp_path: Path) -> None:
    done = lfr("--help", folder=tmp_path)
    assert done.returncode == 0
    assert "view" in done.stdout


def test_help_loads_nothing_heavy() -> None:
    program = """
import sys
from lfr.cli import main
try:
    main(["--help"])
except SystemExit:
    print(sorted(sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    loaded = done.stdout.splitlines()[-1]
    assert "'lfr.cli'" in loaded
    assert not [name for name in HEAVY if f"'{name}'" in loaded]


def test_alone_it_says_where_to_begin(tmp_path: Path) -> None:
    done = lfr(folder=tmp_path)
    assert done.returncode == 0
    assert "lfr verify DATASET" in done.stdout


@pytest.mark.parametrize(
    ("command", "said"),
    [("veiw", "did you mean 'view'?"), ("verfy", "did you mean 'verify'?"), ("x", "there are imp")],
)
def test_no_such_command(tmp_path: Path, command: str, said: str) -> None:
    done = lfr(command, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith(f"lfr: error: unknown command '{command}'; ")
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_view(tmp_path: Path) -> None:
    done = lfr("view", "no/such/place", "--save", "a.rrd", folder=tmp_path)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("lfr: error: ")
    assert "no/such/place" in line
    assert list(tmp_path.iterdir()) == []
