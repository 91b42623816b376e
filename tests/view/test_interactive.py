"""Next and previous beside a viewer that runs."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from rerun.experimental import RrdReader

from lfr.errors import DataError
from lfr.view.interactive import add_recordings, neighbour, step_through
from lfr.view.viewer import ADDRESS, Viewer, executable, free_port

from . import rrd


class Told(Viewer):
    """A viewer that keeps what it is sent, and is closed when there is nothing more to read."""

    def __init__(self) -> None:
        process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
        super().__init__(process, "")
        object.__setattr__(self, "sent", [])

    def send(self, file: Path) -> None:
        self.sent.append(file)  # type: ignore[attr-defined]


@pytest.fixture
def viewer() -> Iterator[Told]:
    told = Told()
    yield told
    told.process.terminate()
    told.process.communicate()


def stepped(viewer: Told, words: list[str]) -> list[str]:
    lines = iter([*words, "q\n"])

    def make(number: int) -> Path:
        if number == 5:
            raise DataError("cannot be shown", file=Path("five"))
        return Path(f"{number}.rrd")

    step_through(viewer, lambda: [2, 5, 9], 2, make, lambda: next(lines))
    return [file.stem for file in viewer.sent]  # type: ignore[attr-defined]


def test_it_leads_on_and_back_and_round(viewer: Told, capsys: pytest.CaptureFixture[str]) -> None:
    assert stepped(viewer, ["9\n", "\n", "p\n"]) == ["9", "2", "9"]
    assert capsys.readouterr().out.splitlines()[1:] == ["episode 9", "episode 2", "episode 9"]


def test_one_that_cannot_be_shown_is_said_and_passed(
    viewer: Told, capsys: pytest.CaptureFixture[str]
) -> None:
    assert stepped(viewer, ["n\n", "n\n"]) == ["9"]
    said = capsys.readouterr()
    assert "cannot be shown" in said.err
    assert said.out.splitlines()[1:] == ["episode 9"]


def test_words() -> None:
    assert neighbour([2, 5, 9], 9, "") == 2
    assert neighbour([2, 5, 9], 2, "p") == 9
    assert neighbour([2, 5, 9], 2, "5") == 5
    assert neighbour([2, 5, 9], 2, "4") is None
    assert neighbour([2, 5, 9], 4, "n") == 2
    assert neighbour([], 4, "n") is None
    assert neighbour([2], 2, "what") is None


def test_a_run_that_goes_on_adds_its_episodes(
    viewer: Told, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = []

    def look() -> list[Path]:
        looks.append(tmp_path / f"episode-{len(looks)}.rrd")
        if len(looks) == 3:
            viewer.process.terminate()
            viewer.process.wait()
        return looks[-1:] if len(looks) != 2 else []

    monkeypatch.setattr(time, "sleep", lambda seconds: None)
    add_recordings(viewer, look)
    names = [file.name for file in viewer.sent]  # type: ignore[attr-defined]
    assert names == ["episode-0.rrd", "episode-2.rrd"]


def test_a_recording_arrives_whole(shown: Path, tmp_path: Path) -> None:
    """rerun itself writes down what it was sent."""
    port, out = free_port(0), tmp_path / "arrived.rrd"
    command = [str(executable()), "--bind", ADDRESS, "--port", str(port), "--save", str(out)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        Viewer(process, f"rerun+http://{ADDRESS}:{port}/proxy").send(shown)
        deadline, sent = time.monotonic() + 60, rrd.read(shown)["/reward"]
        while time.monotonic() < deadline:
            time.sleep(0.5)
            if out.is_file() and _arrived(out):
                break
    finally:
        process.terminate()
        process.wait()
    arrived = rrd.read(out)
    assert arrived["/reward"]["Scalars:scalars"][1] == sent["Scalars:scalars"][1]
    before, after = RrdReader(shown).recordings()[0], RrdReader(out).recordings()[0]
    assert before == after
    assert "/world/robot0_link7/mesh" in arrived


def _arrived(out: Path) -> bool:
    try:
        return "/about" in rrd.read(out) and "/joints" in rrd.read(out)
    except Exception:  # a file that is still being written
        return False
