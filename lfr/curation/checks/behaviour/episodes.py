"""Episodes that are not like the others: twice there, of another length, scale or limit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from lfr.curation.checks.behaviour.signals import Signal, apart, warning
from lfr.curation.contents import Contents, Runs
from lfr.curation.finding import Finding

LENGTH = 3.0  # times shorter or longer than the median
LENGTH_APART = 6.0  # times as far from the median as half of the episodes are
SCALE = 10.0  # times the median episode's reach
PINNED = 0.2  # share of an episode's rows at one bound that is not the dataset's
NEARLY = 1e-2  # of a dimension's spread, between two episodes from row to row
POINTS = 32  # of an episode, by which those that are nearly alike are found


def lengths(contents: Contents, there: Runs) -> Iterator[Finding]:
    """Episodes much shorter or longer than the rest."""
    count = there.length
    if len(count) < 5:
        return
    log = np.log(count)
    far = (np.abs(log - np.median(log)) > np.log(LENGTH)) & apart(log, LENGTH_APART)
    for episode in np.flatnonzero(far):
        what = "shorter" if count[episode] < np.median(count) else "longer or slower"
        yield warning(
            contents, there, int(episode), "length", f"much {what} than the others", column="",
            found=f"{count[episode]} rows", expected=f"{np.median(count):.0f}, the median",
        )  # fmt: skip


def scales(contents: Contents, signal: Signal) -> Iterator[Finding]:
    """Episodes whose numbers reach many times as far as the others': another unit?"""
    reach = np.maximum(np.abs(signal.lowest), np.abs(signal.highest))  # (E, D)
    if len(reach) < 5:
        return
    usual = np.median(reach, axis=0)
    chosen = signal.moving & (usual > 0)
    if not chosen.any():
        return
    far = reach > SCALE * np.maximum(usual, 1e-12)
    for episode in np.flatnonzero(far[:, chosen].mean(axis=1) >= 0.5):
        times = np.median(reach[episode, chosen] / usual[chosen])
        yield warning(
            contents, signal.there, int(episode), "unit",
            "reaches many times as far as the others: another unit?", column=signal.key,
            found=f"{times:.0f} times the median episode's",
        )  # fmt: skip


def pinned(contents: Contents, signal: Signal) -> Iterator[Finding]:
    """Episodes that rest at a bound of their own, within what others reach."""
    there, values = signal.there, signal.values
    if len(there.start) < 5:
        return
    low, high = values.min(axis=0), values.max(axis=0)
    shares = []
    for bound, limit in ((signal.lowest, low), (signal.highest, high)):
        at = values == np.repeat(bound, there.length, axis=0)
        own = np.abs(bound - limit) > 0.02 * signal.spread
        shares.append(np.where(own, signal.of_episodes(at.astype(np.float32)), 0.0))
    share = np.maximum(*shares)  # (E, D)
    constant = signal.lowest == signal.highest
    usual = np.quantile(share, 0.9, axis=0)
    odd = (share > PINNED) & (share > 4 * usual) & signal.moving & ~constant
    for episode in np.flatnonzero(odd.any(axis=1)):
        yield warning(
            contents, there, int(episode), "pinned", "rests at a bound that others go beyond",
            column=signal.named(odd[episode]),
            found=f"{100 * share[episode].max():.0f} % of its rows", expected="few",
        )  # fmt: skip


def twice(contents: Contents, found: list[Signal]) -> Iterator[Finding]:
    """Episodes that are there twice, or nearly."""
    there = found[0].there
    known: dict[bytes, int] = {}
    copies: dict[int, int] = {}
    together = [np.ascontiguousarray(signal.values) for signal in found]
    for episode, (first, count) in enumerate(zip(there.start, there.length, strict=True)):
        digest = hashlib.blake2b(digest_size=16)
        for values in together:
            digest.update(values[first : first + count].tobytes())
        before = known.setdefault(digest.digest(), episode)
        if before != episode:
            copies[episode] = before
    copies |= {one: other for one, other in _nearly(found).items() if one not in copies}
    for episode, other in sorted(copies.items()):
        yield warning(
            contents, there, episode, "duplicate", "the same as another episode, or nearly",
            column="", found=f"episode {int(there.episode[other])}",
        )  # fmt: skip


def _nearly(found: list[Signal]) -> dict[int, int]:
    """Episode -> an earlier one from which no row differs by more than a little."""
    there = found[0].there
    if len(there.start) < 2:
        return {}
    places = there.start[:, None] + np.linspace(0, there.length - 1, POINTS).T.round().astype(int)
    parts = [
        (signal.values[places][..., signal.moving] / signal.spread[signal.moving])
        for signal in found
        if signal.moving.any()
    ]
    if not parts:
        return {}
    points = np.concatenate([part.reshape(len(places), -1) for part in parts], axis=1)
    points = points.astype(np.float32)
    size = points.shape[1]
    squares = (points**2).sum(axis=1)
    alike: dict[int, int] = {}
    for first in range(0, len(points), 512):
        some = points[first : first + 512]
        apart2 = squares[None] + squares[first : first + 512, None] - 2 * some @ points.T
        near = np.sqrt(np.maximum(apart2, 0) / size) < NEARLY
        for row, column in zip(*np.nonzero(near), strict=True):
            episode = first + int(row)
            if column < episode:
                alike.setdefault(episode, int(column))
    return alike
