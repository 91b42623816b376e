"""Which of many episodes: by number, seed, length and outcome, and in which order."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

from lfr.errors import LfrError

Order = Literal["episode", "length", "reward", "seed", "score"]
ORDERS: tuple[Order, ...] = get_args(Order)


@dataclass(frozen=True)
class Entry:
    """What is known of an episode without opening it; None where the data does not say.

    Attributes:
        index: its number in the dataset, or its place among a folder's logs.
        length: frames.
        success: whether its success check held at any frame.
        reward: summed over its frames.
        seed: of its start.
        note: what else there is to say, such as that its file is cut off.
        score: by what `lfr verify` finds, from 0 to 1.
        kinds: of findings that name it.
    """

    index: int
    length: int
    success: bool | None = None
    reward: float | None = None
    seed: int | None = None
    note: str = ""
    score: float | None = None
    kinds: tuple[str, ...] = ()


@dataclass(frozen=True)
class Ranges:
    """Whole numbers, as in `3,5-9` or `40-`: first and last of each range, both included."""

    bounds: tuple[tuple[float, float], ...]
    text: str

    @classmethod
    def parse(cls, text: str) -> Ranges:
        """Raises ValueError where the text is no such list."""
        bounds = []
        for part in text.split(","):
            first, dash, last = (piece.strip() for piece in part.partition("-"))
            if not (first or last) or not all(p.isdecimal() for p in (first, last) if p):
                raise ValueError(f"found {part!r}, expected numbers as in 3,5-9 or 40-")
            low = float(first or 0)
            high = float(last) if last else math.inf if dash else low
            if high < low:
                raise ValueError(f"found {part!r}, which ends before it begins")
            bounds.append((low, high))
        return cls(tuple(bounds), text)

    def __contains__(self, number: int | None) -> bool:
        return number is not None and any(low <= number <= high for low, high in self.bounds)


@dataclass(frozen=True)
class Selection:
    """What to keep of a list, and how to sort it.

    Attributes:
        episodes, seeds, lengths: numbers to keep; None keeps all.
        success: True keeps the episodes that succeeded, False those that are known to have failed.
        findings: keep those that a finding names.
        order: by number, seed and score from the lowest, by length and summed reward from the
            highest.
        reverse: turns the order round.
        first: keep so many, after sorting.
    """

    episodes: Ranges | None = None
    seeds: Ranges | None = None
    lengths: Ranges | None = None
    success: bool | None = None
    findings: bool = False
    order: Order = "episode"
    reverse: bool = False
    first: int | None = None

    def apply(self, entries: Iterable[Entry]) -> list[Entry]:
        """The entries that are kept, in order; what lacks the sorting value comes last.

        Raises:
            LfrError: a number of `episodes` that no entry has.
        """
        every = list(entries)
        self._check(every)
        wanted = (
            (self.episodes, lambda entry: entry.index),
            (self.seeds, lambda entry: entry.seed),
            (self.lengths, lambda entry: entry.length),
        )
        kept = [
            entry
            for entry in every
            if all(ranges is None or value(entry) in ranges for ranges, value in wanted)
            and (self.success is None or entry.success is self.success)
            and (entry.kinds or not self.findings)
        ]
        kept.sort(key=self._key)
        return kept[: self.first]

    @property
    def number(self) -> int | None:
        """The one episode that is chosen by its number alone, so that no list need be read."""
        if self.episodes is None or self != Selection(episodes=self.episodes):
            return None
        return int(self.episodes.text) if self.episodes.text.isdecimal() else None

    def _key(self, entry: Entry) -> tuple[bool, float, int]:
        value = entry.index if self.order == "episode" else getattr(entry, self.order)
        falling = (self.order in ("length", "reward")) != self.reverse
        return value is None, (-1 if falling else 1) * (value or 0), entry.index

    def _check(self, entries: list[Entry]) -> None:
        known = {entry.index for entry in entries}
        for low, high in self.episodes.bounds if self.episodes else ():
            for number in (low, high):
                if math.isfinite(number) and int(number) not in known:
                    raise LfrError(
                        f"no episode {int(number)}; expected 0 to {max(known)}"
                        if known
                        else "no episodes at all"
                    )
