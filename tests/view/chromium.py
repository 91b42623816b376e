"""A headless Chromium that looks at a page, driven over its DevTools protocol.

`LFR_CHROMIUM` names the program where it is not on the path under one of its usual names.
"""

from __future__ import annotations

import asyncio
import base64
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

NAMES = (
    "chromium-headless-shell",
    "chrome-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
)
# WebGL on the processor; a browser that runs as root in a container has no sandbox to offer.
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--remote-debugging-port=0",
)


def chromium() -> str | None:
    """The program, or None where none is installed."""
    named = os.environ.get("LFR_CHROMIUM")
    return named or next((path for name in NAMES if (path := shutil.which(name))), None)


def look(
    program: str,
    url: str,
    until: Callable[[bytes], bool],
    *,
    profile: Path,
    size: tuple[int, int] = (1280, 800),
    patience: float = 300.0,
) -> bytes:
    """A PNG of the page, taken again and again until it is as wanted or `patience` (s) is over.

    Args:
        program: the browser.
        url: of the page.
        until: whether a PNG is as wanted.
        profile: an empty folder that the browser may write to.
        size: of the window, in pixels.
        patience: s; the last picture is returned after that.

    Raises:
        TimeoutError: the browser gave no picture in that time.
    """
    window = f"--window-size={size[0]},{size[1]}"
    command = [program, *FLAGS, window, f"--user-data-dir={profile}", url]
    # A group of its own: the program may be a script that starts the browser and waits.
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        return asyncio.run(_look(_port(profile), until, time.monotonic() + patience))
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait()


def _port(profile: Path) -> int:
    file = profile / "DevToolsActivePort"
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        if file.is_file() and (lines := file.read_text().splitlines()):
            return int(lines[0])
        time.sleep(0.1)
    raise TimeoutError("the browser opened no port within 30 s")


async def _look(port: int, until: Callable[[bytes], bool], deadline: float) -> bytes:
    import aiohttp

    async with aiohttp.ClientSession() as session:
        async with session.get(f"http://127.0.0.1:{port}/json/list") as answer:
            pages = [page for page in await answer.json() if page["type"] == "page"]
        socket = await session.ws_connect(pages[0]["webSocketDebuggerUrl"], max_msg_size=0)
        while True:
            await asyncio.sleep(1.0)
            request = {"id": 1, "method": "Page.captureScreenshot", "params": {"format": "png"}}
            await socket.send_json(request)
            left = max(deadline - time.monotonic(), 1.0)
            answer = await asyncio.wait_for(socket.receive_json(), left)
            picture = base64.b64decode(answer["result"]["data"])
            if until(picture) or time.monotonic() > deadline:
                return picture
