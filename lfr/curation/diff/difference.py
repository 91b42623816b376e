"""One thing in which two datasets, A and B, differ; or that they share where they should not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from lfr.artifacts import as_json
from lfr.curation.finding import short

EpisodePair = tuple[int | None, int | None]
"""An episode's index in A and in B; None where it is not there."""


@dataclass(frozen=True)
class Difference:
    """One of them.

    Attributes:
        kind: its name, e.g. `moved`; see docs/trust.md.
        message: what differs, in words.
        episodes: that it is about, by their index in A and in B.
        column: of the rows, of meta/episodes or of info.json, or dimensions of it.
        a, b: what A has, and B.
        rows: how many rows, or pictures, it is in; 0 where it is not about some.
        largest: the largest difference of two numbers; of pictures, white is 1.
        more: how many others a line stands for whose `a` and `b` are not these.
    """

    kind: str
    message: str
    episodes: tuple[EpisodePair, ...] = ()
    column: str | None = None
    a: Any = None
    b: Any = None
    rows: int = 0
    largest: float | None = None
    more: int = 0

    def __str__(self) -> str:
        """One line for a terminal."""
        where = [listed(self.episodes)] if self.episodes else []
        if self.column is not None:
            where.append(f"column {short(self.column)}")
        if self.a is not None or self.b is not None:
            found = {"A": self.a, "B": self.b}
            where += [f"{name} {'nothing' if v is None else short(v)}" for name, v in found.items()]
        if self.rows:
            where.append(f"{self.rows} row{'' if self.rows == 1 else 's'}")
        if self.largest is not None:
            where.append(f"largest difference {self.largest:.3g}")
        more = f" (and {self.more} more)" if self.more else ""
        line = f"{self.kind}: {short(self.message)}"
        return f"{line}: {', '.join(where)}{more}" if where else line

    def as_json(self) -> dict[str, Any]:
        """For machines: every attribute but `more`, in JSON's types."""
        content = as_json(replace(self, a=None, b=None))
        del content["more"]
        for name in ("a", "b", "largest"):  # JSON has no NaN
            value = getattr(self, name)
            plain = value is None or isinstance(value, bool | int | str)
            finite = isinstance(value, float) and abs(value) < float("inf")
            content[name] = value if plain or finite else short(value)
        return content


def joined(differences: Iterable[Difference]) -> list[Difference]:
    """With those of one kind, in words and column the same, in one line, if they name episodes."""
    lines: dict[tuple[object, ...], list[Difference]] = {}
    for number, one in enumerate(differences):
        key = (one.kind, one.message, one.column, None if one.episodes else number)
        lines.setdefault(key, []).append(one)
    return [_one(line) for line in lines.values()]


def _one(line: list[Difference]) -> Difference:
    first = line[0]
    sizes = [one.largest for one in line if one.largest is not None]
    return replace(
        first, episodes=tuple(pair for one in line for pair in one.episodes),
        rows=sum(one.rows for one in line), largest=max(sizes, default=None),
        more=sum((short(one.a), short(one.b)) != (short(first.a), short(first.b)) for one in line),
    )  # fmt: skip


def listed(episodes: Iterable[EpisodePair]) -> str:
    """Episodes such as `episodes 3, 7-9 (6-8 in B)`, neighbours together."""
    runs = list(_runs(episodes))
    several = len(runs) > 1 or any(count > 1 for _, _, count in runs)
    parts = []
    for a, b, count in runs:
        here, there = _span(a, count), _span(b, count)
        if a is None:
            parts.append(f"{there} of B")
        elif b is None or a == b:
            parts.append(here)
        else:
            parts.append(f"{here} ({there} in B)")
    return short(f"episode{'s' if several else ''} {', '.join(parts)}")


def _span(first: int | None, count: int) -> str:
    return f"{first}" if first is None or count == 1 else f"{first}-{first + count - 1}"


def _runs(episodes: Iterable[EpisodePair]) -> Iterator[tuple[int | None, int | None, int]]:
    """First episode in A and in B of each run in which both go on by one, and how many."""
    ordered = sorted(set(episodes), key=lambda pair: tuple(-1 if i is None else i for i in pair))
    first: EpisodePair | None = None
    count = 0
    for pair in ordered:
        if first is not None and pair == tuple(i if i is None else i + count for i in first):
            count += 1
            continue
        if first is not None:
            yield *first, count
        first, count = pair, 1
    if first is not None:
        yield *first, count
