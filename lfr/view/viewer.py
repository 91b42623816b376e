"""The rerun viewer as a process: on this machine's screen or in a browser, reached from here only.

rerun's own default is to listen on all interfaces, and its Python API cannot change that
(`serve_grpc` has no address); its command line can.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lfr.errors import LfrError, MissingLibraryError

ADDRESS = "127.0.0.1"
DATA_PORT, WEB_PORT = 9876, 9090


def viewer_command(
    files: Sequence[Path], *, web: bool = False, address: str = ADDRESS, follow: bool = False
) -> list[str]:
    """The command line that opens `.rrd` files.

    Args:
        files: recordings.
        web: serve a browser instead of opening a window.
        address: that it listens on; "0.0.0.0" opens it to the network.
        follow: go on reading files that are still being written.
    """
    command = [str(executable()), "--bind", address, "--port", str(free_port(DATA_PORT, address))]
    if web:
        command += ["--serve-web", "--web-viewer-port", str(free_port(WEB_PORT, address))]
    if follow:
        command += ["--follow"]
    return [*command, *map(str, files)]


@dataclass(frozen=True)
class Viewer:
    """A viewer that runs.

    Attributes:
        process: of the viewer, or of the server behind a browser's.
        url: that recordings are sent to.
    """

    process: subprocess.Popen[bytes]
    url: str

    @property
    def open(self) -> bool:
        return self.process.poll() is None

    def send(self, file: Path) -> None:
        """Show the recording of an `.rrd` file, with its blueprint, in the viewer that runs.

        The viewer turns to it (rerun 0.33 turns to whatever arrives, its issue 12950).
        """
        import rerun as rr
        from rerun.experimental import RrdReader

        store = RrdReader(file).recordings()[0]
        carrier = rr.RecordingStream(
            store.application_id, recording_id=store.recording_id, send_properties=False
        )
        with carrier:
            carrier.connect_grpc(self.url)
            carrier.log_file_from_path(file)
            carrier.flush()
            carrier.disconnect()


def show(
    files: Sequence[Path],
    *,
    web: bool,
    address: str = ADDRESS,
    follow: bool = False,
    attend: Callable[[Viewer], None] | None = None,
) -> None:
    """Open recordings and return when the viewer is closed, or interrupted.

    Args:
        files: recordings.
        web: serve a browser instead of opening a window.
        address: that it listens on; "0.0.0.0" opens it to the network.
        follow: go on reading files that are still being written.
        attend: called with the viewer while it runs; it may return before that.

    Raises:
        LfrError: there is no screen to open a window on.
    """
    if not web and not has_screen():
        raise LfrError(
            "there is no screen here; write a file with --save episode.rrd, a picture with "
            "--screenshot episode.png, or serve a browser with --web"
        )
    command = viewer_command(files, web=web, address=address, follow=follow)
    data = command[command.index("--port") + 1]
    if web:
        page = command[command.index("--web-viewer-port") + 1]
        source = f"rerun%2Bhttp%3A%2F%2F{_named(address)}%3A{data}%2Fproxy"
        print(f"open http://{_named(address)}:{page}?url={source} (Ctrl-C ends)", flush=True)
    quiet = {"RUST_LOG": "error", **os.environ}
    process = subprocess.Popen(command, env=quiet, stdin=subprocess.DEVNULL)
    try:
        if attend is not None:
            attend(Viewer(process, f"rerun+http://{_reached(address)}:{data}/proxy"))
        status = process.wait()
    except KeyboardInterrupt:
        return
    finally:
        process.terminate()
        process.wait()
    if status not in (0, 130, -2, -15):
        raise LfrError(f"the rerun viewer ended with status {status}; --save writes a file instead")


def merge(files: Sequence[Path], destination: Path) -> None:
    """Put several recordings into one file."""
    command = [str(executable()), "rrd", "merge", *map(str, files), "-o", str(destination)]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    if result.returncode:
        raise LfrError(f"the recordings could not be merged: {result.stderr.strip()}")


def has_screen() -> bool:
    """Whether a window can be opened: always assumed outside Linux."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def free_port(wanted: int, address: str = ADDRESS) -> int:
    """`wanted`, or any free port if something listens there already."""
    for port in (wanted, 0):
        with socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET) as probe:
            try:
                probe.bind((address, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise LfrError(f"cannot listen on {address}: it is no address of this machine")


def _named(address: str) -> str:
    """What a browser is told: this machine's name where it listens on every address."""
    if address in ("0.0.0.0", "::"):
        return socket.gethostname()
    return f"[{address}]" if ":" in address else address


def _reached(address: str) -> str:
    """Where this machine itself reaches what listens on an address."""
    return ADDRESS if address in ("0.0.0.0", "::") else _named(address)


def executable() -> Path:
    """The program itself: rerun-sdk's `rerun` script would leave it behind when it is ended."""
    import rerun_cli

    name = "rerun.exe" if sys.platform.startswith("win") else "rerun"
    path = Path(rerun_cli.__file__).parent / name
    if not path.is_file():
        raise MissingLibraryError(f"no rerun viewer at {path}; install rerun-sdk again")
    return path
