"""A picture of recordings without a screen: rerun's viewer, drawing to memory."""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import LfrError
from lfr.view.viewer import ADDRESS, DATA_PORT, executable, free_port

SIZE = (1600, 1000)
LOADING, PATIENCE = 3.0, 120.0
"""s; a picture is taken no sooner and no later than this after the viewer has started."""
ANSWER = 20.0
"""s; a frame that the graphics driver does not finish in time is never answered (rerun 0.33)."""

NO_DRIVER = (
    "cannot draw here: rerun needs a Vulkan driver, of a GPU or mesa-vulkan-drivers "
    "(lavapipe); install one, or write a file with --save and open it elsewhere"
)


def take_screenshot(
    files: Sequence[Path], picture: Path, size: tuple[int, int] = SIZE, still: bool = True
) -> None:
    """Write a PNG of what the viewer shows of the first of `files`.

    Args:
        files: recordings.
        picture: the PNG.
        size: of the window, in pixels.
        still: the recording does not play, so that two equal pictures in a row are what it shows.

    Raises:
        LfrError: there is nothing to draw with, or nothing was drawn in time.
    """
    port = free_port(DATA_PORT)
    command = [str(executable()), "--bind", ADDRESS, "--port", str(port), "--headless"]
    command += ["--window-size", f"{size[0]}x{size[1]}", *map(str, files)]
    environment = {"RUST_LOG": "error", **os.environ}
    with tempfile.TemporaryDirectory(prefix="lfr-screenshot-") as folder:
        messages = Path(folder) / "messages"
        with messages.open("wb") as stream:
            process = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=stream,
            )
            try:
                content = _watch(process, port, Path(folder), messages, still)
            finally:
                process.terminate()
                process.wait()
    with write_whole(picture) as whole:
        whole.write_bytes(content)


def _watch(
    process: subprocess.Popen[bytes], port: int, folder: Path, messages: Path, still: bool
) -> bytes:
    """Picture after picture until nothing changes any more."""
    begun, before, number = time.monotonic(), b"", 0
    while (left := begun + PATIENCE - time.monotonic()) > 0:
        if process.poll() is not None:
            raise LfrError(_reason(messages))
        time.sleep(0.5)
        if left > PATIENCE - LOADING:
            continue
        number += 1
        file = folder / f"{number}.png"
        _ask(port, file, min(left, ANSWER))
        content = _whole_png(file)
        if content and (content == before or not still):
            return content
        before = content or before
    if before:
        return before
    raise LfrError(f"the rerun viewer drew nothing within {PATIENCE:.0f} s")


def _ask(port: int, file: Path, seconds: float) -> None:
    """Ask the viewer for a picture, and wait so long for it."""
    from rerun.experimental import ViewerClient

    def ask() -> None:
        # While the viewer starts, and when it ends, rerun raises what its connection does.
        with contextlib.suppress(Exception):
            ViewerClient(f"rerun+http://{ADDRESS}:{port}/proxy").save_screenshot(str(file))

    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    asking.join(seconds)


def _whole_png(file: Path) -> bytes:
    """The PNG's bytes once it is whole, waiting a moment for it; else nothing."""
    for _ in range(20):
        if file.is_file() and (content := file.read_bytes()).endswith(b"IEND\xaeB`\x82"):
            return content
        time.sleep(0.1)
    return b""


def _reason(messages: Path) -> str:
    """Why the viewer ended: its panic stands before the backtrace and where to report it.

    With OpenGL alone rerun (0.33) finds an adapter, but no render context to draw with.
    """
    text = messages.read_text(encoding="utf-8", errors="replace")
    if any(word in text.lower() for word in ("vulkan", "adapter", "render context")):
        return NO_DRIVER
    lines = [line for line in text.splitlines() if line.strip()]
    said = next((line for line in lines if "panicked" in line), lines[-1] if lines else "no reason")
    return f"the rerun viewer ended at once: {said}"
