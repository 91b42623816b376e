"""What is done beside a viewer that runs: step to other episodes, add those that a run leaves."""

from __future__ import annotations

import select
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from lfr.errors import LfrError
from lfr.view.viewer import Viewer

HELP = "Enter: next episode, p: previous, a number: that one, q: end"
POLL_SECONDS = 2.0


def step_through(
    viewer: Viewer,
    numbers: Callable[[], Sequence[int]],
    start: int,
    make: Callable[[int], Path],
    line: Callable[[], str | None] | None = None,
) -> None:
    """Send the viewer the episode that is asked for in the terminal, until either is closed.

    Args:
        viewer: that runs.
        numbers: of the episodes to step through, in order; called when one is asked for.
        start: the episode that it shows already.
        make: writes an episode to an `.rrd` file.
        line: a line that was typed, "" at its end, or None where there was none for a while.
    """
    line = line or typed_line
    here, order = start, None
    print(HELP, flush=True)
    while viewer.open:
        text = line()
        if text is None:
            continue
        word = text.strip().lower()
        if word in ("q", "quit") or text == "":
            if text:
                viewer.process.terminate()
            return
        order = list(numbers()) if order is None else order
        wanted = neighbour(order, here, word)
        if wanted is None:
            print(HELP if not word.isdecimal() else f"no episode {word}", flush=True)
            continue
        try:
            viewer.send(make(wanted))
        except LfrError as error:  # the next one leads on from here all the same
            print(f"lfr: {error}", file=sys.stderr)
        else:
            print(f"episode {wanted}", flush=True)
        here = wanted


def neighbour(order: Sequence[int], here: int, word: str) -> int | None:
    """The episode that a typed word asks for, or None: "" and n lead on, p back, both round."""
    if word.isdecimal():
        return int(word) if int(word) in order else None
    if word not in ("", "n", "next", "p", "previous") or not order:
        return None
    step = -1 if word.startswith("p") else 1
    if here not in order:
        return order[0 if step > 0 else -1]
    return order[(order.index(here) + step) % len(order)]


def typed_line(seconds: float = 0.5) -> str | None:
    """A line of the terminal with its end, "" when it is closed, None after `seconds` without."""
    ready, _, _ = select.select([sys.stdin], [], [], seconds)
    return sys.stdin.readline() if ready else None


def add_recordings(viewer: Viewer, look: Callable[[], list[Path]]) -> None:
    """Send the viewer whatever has come of a run at each look, until it is closed."""
    while viewer.open:
        for file in look():
            viewer.send(file)
        time.sleep(POLL_SECONDS)
