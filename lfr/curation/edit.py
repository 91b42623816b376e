"""Deleting, splitting and merging: new datasets, built aside and renamed when they are whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.curation.assemble import Part, assemble
from lfr.curation.contents import Contents
from lfr.curation.finding import Unreadable
from lfr.errors import DataError, LfrError

Counts = dict[str, int]


def delete_episodes(path: Path, episodes: Sequence[int], out: Path) -> Counts:
    """The dataset at `path` without these episodes, as the new dataset `out`.

    Raises:
        DataError: an episode is not there, or nothing is left; see `assemble`.
        LfrError: there is something at `out`.
    """
    known = _count(path)
    for episode in episodes:
        if not 0 <= episode < known:
            raise DataError("no such episode", file=path, episode=episode,
                            expected=f"0 to {known - 1}")  # fmt: skip
    kept = [episode for episode in range(known) if episode not in set(episodes)]
    return _one([Part(path, kept)], out)


def split_episodes(path: Path, splits: Mapping[str, Sequence[int]], out: Path) -> dict[str, Counts]:
    """Each part as the new dataset `out/<name>`; all of them appear at once.

    Raises:
        DataError: an episode is not there; see `assemble`.
        LfrError: an episode is in two parts, or there is something at `out`.
    """
    owner: dict[int, str] = {}
    for name, episodes in splits.items():
        for episode in episodes:
            if owner.setdefault(episode, name) != name:
                raise LfrError(f"episode {episode} is in {owner[episode]!r} and in {name!r}")
    _free(out)
    with write_whole(out) as partial:
        return {
            name: assemble([Part(path, episodes)], partial / name)
            for name, episodes in splits.items()
        }


def merge_datasets(paths: Sequence[Path], out: Path) -> Counts:
    """All episodes of these datasets, one after the other, as the new dataset `out`.

    Raises:
        DataError: they are not of one kind; see `assemble`.
        LfrError: there is something at `out`.
    """
    return _one([Part(path, range(_count(path))) for path in paths], out)


def parse_episodes(text: str, path: Path) -> list[int]:
    """Episodes such as `0,3,7-9`, in the order given.

    Raises:
        LfrError: it is not that.
    """
    episodes = []
    for piece in text.split(","):
        first, dash, last = piece.strip().partition("-")
        if not first.isdigit() or (dash and not last.isdigit()):
            raise LfrError(f"episodes of {path}: found {text!r}, expected such as 0,3,7-9")
        episodes += range(int(first), int(last or first) + 1)
    return episodes


def parse_splits(texts: Sequence[str], path: Path) -> dict[str, list[int]]:
    """Parts such as `train=0-39 test=40-49`, or fractions such as `train=0.8 test=0.2`.

    Fractions take the episodes in their order.

    Raises:
        LfrError: it is neither, or the fractions add up to more than 1.
    """
    pieces = [text.partition("=") for text in texts]
    named = {name: value for name, _, value in pieces}
    if len(named) != len(texts) or not all(named) or not all(named.values()):
        raise LfrError(f"parts: found {' '.join(texts)!r}, expected such as train=0-39 test=40-49")
    if not any("." in value for value in named.values()):
        return {name: parse_episodes(value, path) for name, value in named.items()}
    try:
        fractions = {name: float(value) for name, value in named.items()}
    except ValueError:
        raise LfrError(f"parts: found {' '.join(texts)!r}, expected fractions") from None
    if sum(fractions.values()) > 1 + 1e-9 or min(fractions.values()) <= 0:
        raise LfrError(f"parts: fractions of {sum(fractions.values()):g} in all, expected 1")
    known, done, splits = _count(path), 0.0, {}
    for name, fraction in fractions.items():
        splits[name] = list(range(round(done * known), round((done + fraction) * known)))
        done += fraction
    return splits


def _one(parts: Sequence[Part], out: Path) -> Counts:
    _free(out)
    with write_whole(out) as partial:
        return assemble(parts, partial)


def _free(out: Path) -> None:
    if out.exists():
        raise LfrError(f"{out} is there already; expected a new folder")


def _count(path: Path) -> int:
    try:
        return len(Contents.open(path).episodes)
    except Unreadable as unreadable:
        finding = unreadable.finding
        raise DataError(finding.message, file=path / finding.file, found=finding.found) from None
