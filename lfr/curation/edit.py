"""Deleting, splitting and merging: new datasets, built aside and renamed when they are whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.curation.assemble import assemble
from lfr.curation.contents import Contents
from lfr.curation.finding import readable
from lfr.curation.parts import Part
from lfr.errors import DataError, LfrError

Counts = dict[str, int]


def delete_episodes(path: Path, episodes: Sequence[int], out: Path) -> Counts:
    """The dataset at `path` without these episodes, as the new dataset `out`.

    Raises:
        DataError: an episode is not there, or nothing is left; see `assemble`.
        LfrError: there is something at `out`.
    """
    known = _known(path)
    for episode in episodes:
        if episode not in known:
            there = f"{min(known)} to {max(known)}" if known else "none"
            raise DataError("no such episode", file=path, episode=episode, expected=there)
    kept = [episode for episode in known if episode not in set(episodes)]
    return _one([Part(path, kept)], out)


def split_episodes(path: Path, splits: Mapping[str, Sequence[int]], out: Path) -> dict[str, Counts]:
    """Each part as the new dataset `out/<name>`; all of them appear at once.

    Raises:
        DataError: an episode is not there; see `assemble`.
        LfrError: an episode is named twice, a name is no folder's, or there is something at `out`.
    """
    owner: dict[int, str] = {}
    for name, episodes in splits.items():
        if Path(name).name != name or name.startswith("."):
            raise LfrError(
                f"parts: found the name {name!r}, expected one of a folder, such as train"
            )
        for episode in episodes:
            if episode in owner:
                raise LfrError(
                    f"episode {episode} is named twice, in {owner[episode]!r} and in {name!r}"
                )
            owner[episode] = name
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
        LfrError: one is named twice, or there is something at `out`.
    """
    places = [path.resolve() for path in paths]
    for path, place in zip(paths, places, strict=True):
        if places.count(place) > 1:
            raise LfrError(f"found {path} twice; expected each dataset once")
    return _one([Part(path, _known(path)) for path in paths], out)


def parse_episodes(text: str, path: Path) -> list[int]:
    """Episodes such as `0,3,7-9`, in the order given.

    Raises:
        LfrError: it is not that, or a range ends before it begins.
    """
    episodes = []
    for piece in text.split(","):
        first, dash, last = (part.strip() for part in piece.partition("-"))
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise LfrError(f"episodes of {path}: found {text!r}, expected such as 0,3,7-9")
        numbers = range(int(first), int(last or first) + 1)
        if not numbers:
            raise LfrError(f"episodes of {path}: found {piece!r}, which ends before it begins")
        episodes += numbers
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
    if sum(fractions.values()) > 1 + 1e-9 or not all(f > 0 for f in fractions.values()):
        raise LfrError(f"parts: fractions of {sum(fractions.values()):g} in all, expected 1")
    known, done, splits = _known(path), 0.0, {}
    count = len(known)
    for name, fraction in fractions.items():
        splits[name] = known[round(done * count) : round((done + fraction) * count)]
        done += fraction
    return splits


def _one(parts: Sequence[Part], out: Path) -> Counts:
    _free(out)
    with write_whole(out) as partial:
        return assemble(parts, partial)


def _free(out: Path) -> None:
    if out.exists():
        raise LfrError(f"{out} is there already; expected a new folder")


def _known(path: Path) -> list[int]:
    """The episodes there are, by their index."""
    with readable(path):
        return Contents.open(path).episode_column("episode_index").tolist()
