"""What moves too fast: jumps and spikes by their steps, noise by its second differences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.behaviour.signals import Signal, warning
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding

JUMP = 4.0  # times the step that one in a thousand exceeds, of the other episodes
LEAST = 0.1  # of its spread
RARE = 0.1  # share of the episodes: what happens more often is how it moves
NOISE = 5.0  # times the median episode's
NOISE_LEAST = 0.01  # of its spread
# Correlation of successive second differences: white noise has -2/3, a hand that opens and closes
# often one above 0.
ALTERNATING = -0.2
TURNS = (2 * np.pi, 360.0)


def jumps(contents: Contents, signal: Signal) -> Iterator[Finding]:
    """Single steps that no other episode has anything like."""
    there, steps = signal.there, signal.steps
    if len(there.start) < 2:
        return
    usual = np.quantile(steps, 0.999, axis=0)
    # what one episode alone does must not set the measure by which it is judged
    highest = np.maximum.reduceat(steps, there.start, axis=0)  # (E, D)
    usual = np.minimum(usual, np.quantile(highest, 0.9, axis=0))
    far = (steps > np.maximum(JUMP * usual, LEAST * signal.spread)) & signal.moving
    rows = np.flatnonzero(far.any(axis=1))
    episodes = np.searchsorted(there.start, rows, side="right") - 1
    if not len(rows) or len(np.unique(episodes)) > max(RARE * len(there.start), 1):
        return
    for episode in np.unique(episodes):
        own = rows[episodes == episode]
        at = int(own[0])
        yield warning(
            contents, there, int(episode), "jump", _what(signal, far, at, int(own[-1])),
            column=signal.named(far[at]), first=at, last=int(own[-1]),
            found=f"{steps[at][far[at]].max():.3g} in one step",
            expected=f"at most {usual[far[at]].max():.3g} in most episodes", places=len(own),
        )  # fmt: skip


def noise(contents: Contents, signal: Signal) -> Iterator[Finding]:
    """Episodes that tremble many times as much as the others."""
    there, values = signal.there, signal.values
    if len(there.start) < 3 or len(values) < 3:
        return
    bends = np.pad(np.diff(values, n=2, axis=0), ((1, 1), (0, 0)))
    second = np.abs(bends)
    middle = np.array([
        np.median(second[first + 1 : first + count - 1], axis=0) if count > 4
        else np.zeros(values.shape[1])
        for first, count in zip(there.start, there.length, strict=True)
    ])  # fmt: skip
    usual = np.median(middle, axis=0)
    odd = (middle > NOISE * usual) & (middle > NOISE_LEAST * signal.spread) & signal.moving
    for episode in np.flatnonzero(odd.any(axis=1)):
        first, count = there.start[episode], there.length[episode]
        d = bends[first + 1 : first + count - 1]
        turns = (d[1:] * d[:-1]).sum(axis=0) < ALTERNATING * (d * d).sum(axis=0)
        chosen = odd[episode] & turns
        if not chosen.any():
            continue
        times = (middle[episode][chosen] / np.maximum(usual[chosen], 1e-12)).max()
        yield warning(
            contents, there, int(episode), "noise", "trembles more than the other episodes",
            column=signal.named(chosen), found=f"{min(times, 9999):.0f} times the median episode's",
        )  # fmt: skip


def _what(signal: Signal, far: NDArray[np.bool_], first: int, last: int) -> str:
    chosen = far[first]
    size = np.abs(signal.values[first] - signal.values[first - 1])[chosen]
    if any(np.allclose(size, turn, rtol=0.1) for turn in TURNS):
        return "jumps by a turn: an angle that wraps?"
    if chosen.sum() >= max(2, signal.moving.sum() / 2):
        return "most dimensions jump: two episodes in one, or a stretch cut out?"
    if last == first + 1 and (far[first] == far[last]).all():
        return "a single row far from its neighbours"
    return "jumps"
