"""How good each episode is: 1 where nothing is found, 0 with an error, halved by each warning."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from lfr.curation.contents import Contents
from lfr.curation.finding import Finding, Unreadable

BEST = 1.0
COLUMNS = ("episode", "frames", "score", "kinds")


@dataclass(frozen=True)
class Score:
    """What is said of an episode.

    Attributes:
        frames: that it has, as meta/episodes counts them.
        score: 1 where no finding names it, 0 where an error does, else halved for each kind of
            warning that does.
        kinds: of the findings that name it.
    """

    episode: int
    frames: int
    score: float
    kinds: tuple[str, ...]


def episode_lengths(contents: Contents) -> tuple[int, ...]:
    """Frames of each episode; 0 where meta/episodes does not say; none if it cannot be read."""
    try:
        lengths = contents.episodes["length"].to_pylist()
    except Unreadable:
        return ()
    return tuple(length if isinstance(length, int) else 0 for length in lengths)


def scores(findings: Iterable[Finding], lengths: Sequence[int]) -> list[Score]:
    """Of every episode, in order.

    Args:
        findings: of the dataset.
        lengths: (E,) frames of each episode.
    """
    kinds: list[dict[str, None]] = [{} for _ in lengths]
    wrong = [False] * len(lengths)
    for finding in findings:
        for episode in finding.episodes:
            if 0 <= episode < len(lengths):
                kinds[episode][finding.check] = None
                wrong[episode] |= finding.severity == "error"
    return [
        Score(episode, length, 0.0 if wrong[episode] else 0.5 ** len(named), tuple(named))
        for episode, (length, named) in enumerate(zip(lengths, kinds, strict=True))
    ]


def about_all(findings: Iterable[Finding], lengths: Sequence[int]) -> list[Finding]:
    """Those that are about the whole dataset: they name no episode of it."""
    return [f for f in findings if not any(0 <= e < len(lengths) for e in f.episodes)]


def table(found: Sequence[Score]) -> str:
    """The scores as lines of text."""
    rows = [(str(s.episode), str(s.frames), f"{s.score:g}", ", ".join(s.kinds)) for s in found]
    widths = [max(map(len, column)) for column in zip(COLUMNS, *rows, strict=True)]
    lines = []
    for *numbers, named in (COLUMNS, *rows):
        cells = (cell.rjust(width) for cell, width in zip(numbers, widths[:3], strict=True))
        lines.append("  ".join([*cells, named]).rstrip())
    return "\n".join(lines)


def good(found: Sequence[Score], least: float = BEST) -> list[int]:
    """The episodes that score so much or more."""
    return [score.episode for score in found if score.score >= least]
