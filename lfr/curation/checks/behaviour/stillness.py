"""What does not move: stuck sensors, dead dimensions, idle ends, rows that repeat."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.behaviour.signals import Pair, Signal, stretches, warning
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding
from lfr.data.episode import ACTION

STUCK = 1.0  # seconds
MOVED = 0.1  # of its spread, that an action goes meanwhile
USUAL = 0.9  # share of the episodes that do what the rest does not
FEW = 5  # episodes, with which nothing can be said of the usual
IDLE = 0.02  # of its spread, that each dimension stays within for a second
IDLE_END = 3.0  # seconds, and as many times as long as half of the episodes'
REPEATED = 0.3  # share of an episode's rows
GRIPPERS = ("grip", "finger", "claw", "jaw")  # stand still on what they hold


def stuck(contents: Contents, signal: Signal, action: Signal, own: bool) -> Iterator[Finding]:
    """Values that stay exactly the same while an action goes on.

    Args:
        own: whether the action has the same dimensions; else all of the state must stay.
    """
    there, least = signal.there, max(int(STUCK * contents.fps), 2)
    masks = list(signal.same.T) if own else [np.asarray(signal.same.all(axis=1))]
    found: dict[tuple[int, int, int], list[int]] = {}
    for place, mask in enumerate(masks):
        if own and _is_gripper(signal.names[place]):
            continue
        for start, length in zip(*stretches(mask), strict=True):
            if length < least:
                continue
            window = action.values[start : start + length, place if own else slice(None)]
            spread = action.spread[place if own else slice(None)]
            reached = np.ptp(window, axis=0)
            if np.any((reached > MOVED * spread) & (spread > 0)):
                episode = int(np.searchsorted(there.start, start, side="right")) - 1
                found.setdefault((episode, int(start), int(length)), []).append(place)
    for (episode, start, length), places in found.items():
        if own and not signal.spread[places].any():
            continue  # constant in all rows, which the check of values says once
        yield warning(
            contents, there, episode, "stuck", "does not move while the action does",
            column=signal.named(places) if own else signal.key, first=start - 1,
            last=start + length - 1, found=f"{length / contents.fps:.1f} s the same",
        )  # fmt: skip


def still(contents: Contents, signal: Signal) -> Iterator[Finding]:
    """Dimensions that never change in an episode and do in nearly all others: dead, or at a limit
    all along.
    """
    there = signal.there
    constant = signal.lowest == signal.highest  # (E, D)
    long = there.length >= contents.fps * STUCK
    if long.sum() < FEW:
        return
    usual = (~constant[long]).mean(axis=0) >= USUAL
    odd = constant & usual & long[:, None]
    for episode in np.flatnonzero(odd.any(axis=1)):
        moved = 100 * (~constant[long]).mean(axis=0)[odd[episode]].min()
        yield warning(
            contents, there, int(episode), "still",
            "never changes in this episode: dead, or at a limit?",
            column=signal.named(odd[episode]), expected=f"changes in {moved:.0f} % of the episodes",
        )  # fmt: skip


def idle(contents: Contents, found: list[Signal]) -> Iterator[Finding]:
    """Beginnings and ends in which nothing happens, much longer than the other episodes'."""
    there, window = found[0].there, max(int(contents.fps), 2)
    quiet = np.ones(len(found[0].values), bool)
    for signal in found:
        quiet &= _quiet(signal, window)
    heads, tails = _ends(quiet, there.start, there.length)
    for lengths, name in ((heads, "beginning"), (tails, "end")):
        seconds = lengths / contents.fps
        # half of the episodes are idle for the median; where all are, that is how it is recorded
        long = (seconds >= IDLE_END) & (seconds >= IDLE_END * np.median(seconds) + 1.0)
        for episode in np.flatnonzero(long):
            first = int(there.start[episode])
            if name == "end":
                first += int(there.length[episode] - lengths[episode])
            yield warning(
                contents, there, int(episode), "idle", f"nothing moves at its {name}", column="",
                first=first, last=first + int(lengths[episode]) - 1,
                found=f"{seconds[episode]:.1f} s",
                expected=f"{np.median(seconds):.1f} s, the median",
            )  # fmt: skip


def repeated(contents: Contents, found: list[Signal]) -> Iterator[Finding]:
    """Episodes of which many rows repeat the one before: recorded at a lower rate than they say."""
    there = found[0].there
    same = np.asarray(np.concatenate([signal.same for signal in found], axis=1).all(axis=1))
    start, length = stretches(same)
    brief = length < contents.fps  # longer ones stand still
    rows = np.zeros(len(same), np.int64)
    for first, count in zip(start[brief], length[brief], strict=True):
        rows[first : first + count] = 1
    share = np.add.reduceat(rows, there.start) / there.length
    odd = (share > REPEATED) & (there.length >= contents.fps)
    if not odd.any():
        return
    episode = int(np.argmax(odd))
    yield warning(
        contents, there, episode, "repeated-rows",
        "rows repeat the one before; recorded at a lower rate than the dataset says?", column="",
        found=f"{100 * share[odd].mean():.0f} % of the rows", expected="few", places=int(odd.sum()),
        episodes=tuple(np.unique(there.episode[odd]).tolist()),
    )  # fmt: skip


def stillness(contents: Contents, found: list[Signal], pair: Pair | None) -> Iterator[Finding]:
    """All of these."""
    action = next((signal for signal in found if signal.key == ACTION), None)
    if pair is not None:
        yield from stuck(contents, pair.state, pair.action, own=True)
    elif action is not None:
        for signal in found:
            if signal.key.startswith("observation.state"):
                yield from stuck(contents, signal, action, own=False)
    for signal in found:
        yield from still(contents, signal)
    yield from idle(contents, found)
    yield from repeated(contents, found)


def _is_gripper(name: str) -> bool:
    return any(part in name.lower() for part in GRIPPERS)


def _quiet(signal: Signal, window: int) -> NDArray[np.bool_]:
    """(N,) rows around which no moving dimension goes further than a little, in a second."""
    values, chosen = signal.values, signal.moving
    if not chosen.any():
        return np.ones(len(values), bool)
    near = np.ones(len(values), bool)
    scaled = values[:, chosen] / signal.spread[chosen]
    half = window // 2
    ahead = np.abs(scaled[half:] - scaled[:-half]).max(axis=1) if len(values) > half else None
    if ahead is None:
        return near
    near[:-half] &= ahead < IDLE
    near[half:] &= ahead < IDLE
    # across an episode's border the rows are of two episodes, so a border is quiet by itself
    for start in signal.there.start[1:]:
        near[max(start - half, 0) : start] = _within(scaled, start - half, start)
        near[start : start + half] = _within(scaled, start, start + half)
    return near


def _within(scaled: NDArray, first: int, last: int) -> bool:
    part = scaled[max(first, 0) : last]
    return bool(len(part)) and bool((np.ptp(part, axis=0) < IDLE).all())


def _ends(quiet: NDArray[np.bool_], start: NDArray, length: NDArray) -> tuple[NDArray, NDArray]:
    """(E,) how many rows at each episode's beginning, and at its end, are quiet."""
    heads, tails = np.zeros(len(start), np.int64), np.zeros(len(start), np.int64)
    for episode, (first, count) in enumerate(zip(start, length, strict=True)):
        loud = np.flatnonzero(~quiet[first : first + count])
        heads[episode] = loud[0] if len(loud) else count
        tails[episode] = count - 1 - loud[-1] if len(loud) else 0
    return heads, tails
