"""`lfr view`: what it takes, what it refuses, and whom its server listens to."""

import socket
import subprocess
import time
from pathlib import Path

import pytest

from lfr.cli import main
from lfr.errors import LfrError
from lfr.view.viewer import free_port, viewer_command

from . import rrd


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.mcap", None, "does not exist"),
        ("notes.txt", b"hello", "found a .txt file"),
        ("cut.mcap", b"\x89MCAP0\r\nxx", "cut-off MCAP"),
        ("empty", "folder", "found nothing of a dataset, a log or a run"),
    ],
)
def test_a_bad_path_is_one_line(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    content: bytes | str | None,
    said: str,
) -> None:
    path = tmp_path / name
    if content == "folder":
        path.mkdir()
    elif isinstance(content, bytes):
        path.write_bytes(content)
    out = tmp_path / "out.rrd"
    assert main(["view", str(path), "--save", str(out)]) == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert str(path) in error
    assert len(error.splitlines()) == 1
    assert not out.exists()


def test_without_a_screen_it_says_what_to_do(
    shown: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert main(["view", str(shown)]) == 2
    assert "--save" in capsys.readouterr().err


def test_a_folder_of_recordings_is_one_file(shown: Path, tmp_path: Path) -> None:
    from lfr.view.curve import save_learning

    folder = tmp_path / "seed-0"
    folder.mkdir()
    (folder / "sample.rrd").write_bytes(shown.read_bytes())
    save_learning(folder / "learning.rrd", [{"env_steps": 0, "success": 0.5}], "run")
    assert main(["view", str(folder), "--save", str(tmp_path / "all.rrd")]) == 0
    from rerun.experimental import RrdReader

    assert len(RrdReader(tmp_path / "all.rrd").recordings()) == 2


def test_the_server_listens_on_this_machine_alone(shown: Path) -> None:
    command = viewer_command([shown], web=True)
    ports = {int(command[command.index(f) + 1]) for f in ("--port", "--web-viewer-port")}
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 30
        while not ports <= {port for port, _ in _listening()} and time.monotonic() < deadline:
            time.sleep(0.2)
        addresses = {address for port, address in _listening() if port in ports}
    finally:
        process.terminate()
        process.wait()
    assert addresses == {"127.0.0.1"}


def _listening() -> set[tuple[int, str]]:
    """Port and address of every listening TCP socket of this machine, from the kernel's table."""
    found = set()
    for family, file in ((socket.AF_INET, "tcp"), (socket.AF_INET6, "tcp6")):
        table = Path(f"/proc/net/{file}")
        if not table.exists():
            pytest.skip("the kernel has no table of sockets to read")
        for line in table.read_text().splitlines()[1:]:
            local, state = line.split()[1], line.split()[3]
            if state == "0A":  # LISTEN
                address, port = local.split(":")
                words = [bytes.fromhex(address[i : i + 8])[::-1] for i in range(0, len(address), 8)]
                found.add((int(port, 16), socket.inet_ntop(family, b"".join(words))))
    return found


def test_a_taken_port_is_passed_over() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert free_port(port) != port


def test_an_address_of_another_machine_is_told() -> None:
    with pytest.raises(LfrError, match=r"cannot listen on 192\.0\.2\.1"):  # for documents only
        free_port(0, "192.0.2.1")


def test_the_saved_file_holds_the_arm(shown: Path) -> None:
    assert "/world/robot0_link7/mesh" in rrd.read(shown)
