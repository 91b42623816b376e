"""A progress bar with rate and time left; lines instead of a bar where there is no terminal."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterable
from typing import TextIO, cast

from tqdm import tqdm

LINE_INTERVAL = 5.0  # seconds between two lines where there is no terminal


class _Lines(io.TextIOBase):
    """A stream that turns the bar's redrawing into a line each time."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        line = text.strip("\r\n ")
        if line:
            self._stream.write(line + "\n")
        return len(text)

    def flush(self) -> None:
        self._stream.flush()


def progress[Item](
    work: Iterable[Item] | int, description: str = "", unit: str = "it", *, initial: int = 0
) -> tqdm[Item]:
    """A tqdm bar over an iterable, or over a count to be moved on with ``.update(n)``.

    On a terminal it is a bar. Elsewhere it is silent, so that logs and tests stay clean, unless
    the environment has ``LFR_PROGRESS=1``: then a line every few seconds. ``initial`` is what was
    done before and does not count for the rate.
    """
    iterable = cast("Iterable[Item]", None if isinstance(work, int) else work)
    total = work if isinstance(work, int) else None
    terminal = sys.stderr.isatty()
    lines = not terminal and os.environ.get("LFR_PROGRESS") == "1"
    return tqdm(
        iterable,
        total=total,
        initial=initial,
        desc=description or None,
        unit=unit,
        file=_Lines(sys.stderr) if lines else sys.stderr,
        mininterval=LINE_INTERVAL if lines else 0.2,
        maxinterval=LINE_INTERVAL if lines else 10.0,
        dynamic_ncols=terminal,
        disable=not (terminal or lines),
    )
