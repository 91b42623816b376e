"""Two datasets held against each other, and what came of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.curation.diff.columns import Shared, shared_columns
from lfr.curation.diff.difference import Difference, joined
from lfr.curation.diff.episodes import compare_episodes
from lfr.curation.diff.features import compare_features
from lfr.curation.diff.leakage import find_leaks
from lfr.curation.diff.matching import matched
from lfr.curation.diff.pictures import compare_pictures
from lfr.curation.diff.side import Side
from lfr.curation.diff.statistics import STATISTICS, compare_statistics
from lfr.curation.finding import short

STRIDE, LINES = 10, 10


@dataclass(frozen=True)
class Comparison:
    """What was found.

    Attributes:
        a, b: what the datasets are called: their folders, or names on the Hub.
        episodes: of A and of B.
        differences: all of them, of one episode each; or what is shared, where that was asked.
        same: episodes of both in which nothing differs.
        not_compared: what could not be looked at, and why.
        leakage: whether what is shared was asked.
        named: how many dimensions have a line at most, whose statistics have moved.
    """

    a: Path
    b: Path
    episodes: tuple[int, int]
    differences: tuple[Difference, ...]
    same: int = 0
    not_compared: tuple[str, ...] = ()
    leakage: bool = False
    named: int = LINES

    @property
    def counts(self) -> dict[str, int]:
        """Of each kind, how many episodes it is about; of what is about none, how often it is."""
        about = {(one.kind, one.episodes or number) for number, one in enumerate(self.differences)}
        found = Counter(kind for kind, _ in about)
        return {one.kind: found[one.kind] for one in self.differences}

    @property
    def lines(self) -> list[Difference]:
        """Episodes of which the same is said in one line."""
        moved = [one for one in self.differences if one.kind == STATISTICS]
        others = [one for one in self.differences if one.kind != STATISTICS]
        lines = joined(others) + moved[: self.named]
        if rest := len(moved[self.named :]):
            lines.append(
                Difference(STATISTICS, f"moved, {rest} more dimensions, by less (--lines)")
            )
        return lines

    def __str__(self) -> str:
        """The last line."""
        counts = [f"{count} {kind}" for kind, count in self.counts.items()]
        nothing = "nothing is shared" if self.leakage else "nothing differs"
        found = ", ".join(counts) if counts else nothing
        if not self.leakage:
            found = f"{self.same} the same; {found}"
        rest = (
            f"; not compared: {', '.join(map(short, self.not_compared))}"
            if self.not_compared
            else ""
        )
        a, b = (short(path) for path in (self.a, self.b))
        return f"A {a}, B {b}: {self.episodes[0]} and {self.episodes[1]} episodes: {found}{rest}"

    def as_json(self) -> dict[str, Any]:
        return {
            "a": str(self.a), "b": str(self.b), "episodes": list(self.episodes),
            "leakage": self.leakage, "same": self.same, "counts": self.counts,
            "not_compared": list(self.not_compared),
            "differences": [one.as_json() for one in self.differences],
        }  # fmt: skip


def compare_datasets(a: Path, b: Path, *, pictures: int = STRIDE, lines: int = LINES) -> Comparison:
    """What differs between two LeRobot datasets; nothing is written to them.

    Args:
        a, b: folders of v3.0, or what `lfr.curation.diff.forms.as_dataset` gave.
        pictures: every how many frames one is decoded and compared, of episodes whose packets
            differ; 0 leaves the videos.
        lines: how many dimensions have a line at most, whose statistics have moved.

    Raises:
        DataError: one is no such dataset, or cannot be read.
    """
    sides, shared, not_compared = _opened(a, b)
    found = matched(*sides, shared)
    differences = list(compare_features(*sides))
    differences += compare_episodes(*sides, shared, found)
    if pictures:
        differences += compare_pictures(*sides, found, pictures)
    else:
        not_compared.append("pictures")
    differences += compare_statistics(*sides, shared)
    other = {pair for one in differences for pair in one.episodes}
    x, y = (side.episode.tolist() for side in sides)
    same = sum((x[one], y[two]) not in other for one, two in found.pairs)
    return Comparison(sides[0].name, sides[1].name, (len(x), len(y)), tuple(differences), same,
                      tuple(not_compared), named=lines)  # fmt: skip


def compare_leakage(train: Path, test: Path, *, pictures: bool = True) -> Comparison:
    """What a training set, A, and a test set, B, share.

    Args:
        train, test: as `a` and `b` of `compare_datasets`.
        pictures: whether to look for key frames that both have.

    Raises:
        DataError: one is no such dataset, or cannot be read.
    """
    sides, shared, not_compared = _opened(train, test)
    found = list(find_leaks(*sides, shared, pictures, not_compared))
    if not pictures:
        not_compared.append("pictures")
    return Comparison(sides[0].name, sides[1].name, (len(sides[0]), len(sides[1])), tuple(found),
                      not_compared=tuple(not_compared), leakage=True)  # fmt: skip


def _opened(a: Path, b: Path) -> tuple[tuple[Side, Side], list[Shared], list[str]]:
    sides = Side.open(Path(a)), Side.open(Path(b))
    shared, apart = shared_columns(*sides)
    return sides, shared, [f"{key} (other shapes)" for key in apart]
