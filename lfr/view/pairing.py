"""Which two recordings stand side by side: a demonstration and another, or a policy's attempt."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from lfr.data.opening import opened
from lfr.errors import LfrError
from lfr.view.collection import Collection, collection_of
from lfr.view.recordings import Wanted, existing, going, is_policy, recordings, save_policy
from lfr.view.selection import Ranges, Selection
from lfr.view.side_by_side import save_side_by_side


def save_pair(out: Path, path: Path, other: str, folder: Path, wanted: Wanted) -> None:
    """Write what is at `path` and what `other` names into one file, side by side.

    Without a number, the other dataset's episode is the one that starts from the same seed; a
    policy starts from it too, so that two arms are seen at the same start.

    Args:
        out: the file.
        path: as `lfr.view.recordings.recordings` takes it.
        other: a path, with `:N` for its episode, or N alone for another episode of `path`.
        folder: for what is made on the way.
        wanted: of the left one.

    Raises:
        LfrError: one of them cannot be shown.
    """
    left = one_of(path, folder / "left", wanted)
    seed = _seed(existing(path), wanted)
    place, number = parse_other(other, path)
    with opened(going(place)) as there:
        right = one_of(there, folder / "right", _answer(existing(there), number, seed, wanted))
    save_side_by_side(out, left, right, at=wanted.at)


def parse_other(text: str, path: Path) -> tuple[Path, int | None]:
    """The path and the episode that `--side-by-side` names; a path that is there is one."""
    if Path(text).exists():
        return Path(text), None
    if text.isdecimal():
        return path, int(text)
    head, colon, tail = text.rpartition(":")
    if colon and tail.isdecimal():
        return Path(head), int(tail)
    return Path(text), None


def one_of(path: Path, folder: Path, wanted: Wanted) -> Path:
    """The one recording that shows what is at `path`; of a run, the last episode that it left.

    Raises:
        LfrError: there is more than one episode, or none.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = existing(path)
    if is_policy(path):
        return save_policy(path, folder, wanted.seed)
    shown = recordings(path, folder, wanted)
    if not shown.run:
        if len(shown.files) != 1:
            raise LfrError(f"side by side stand two: found {len(shown.files)} episodes of {path}, "
                           "expected one; choose it with --episode")  # fmt: skip
        return shown.files[0]
    episodes = [file for file in shown.files if file.name.startswith("episode-")]
    if not episodes:
        raise LfrError(f"{path} has left no episode yet that could stand beside another")
    return episodes[-1]


def _answer(path: Path, number: int | None, seed: int | None, wanted: Wanted) -> Wanted:
    """What is wanted of the right one."""
    unselected = replace(wanted, selection=None, seed=None, skills=None, mapping=None)
    collection = collection_of(path)
    if collection is None:
        if number is not None:
            raise LfrError(f"{path} has no episodes to choose from; expected a dataset or logs")
        return replace(unselected, seed=seed)
    if number is None:
        number = _with_seed(collection, seed)
    return replace(unselected, selection=Selection(episodes=Ranges.parse(str(number))))


def _seed(path: Path, wanted: Wanted) -> int | None:
    """The start of the left one, where it is known."""
    collection = collection_of(path)
    if collection is None:
        return wanted.seed
    kept = (wanted.selection or Selection()).apply(collection.entries())
    return kept[0].seed if kept else None


def _with_seed(collection: Collection, seed: int | None) -> int:
    entries = collection.entries()
    if not entries:
        raise LfrError(f"{collection.name} has no episodes")
    return next((e.index for e in entries if seed is not None and e.seed == seed), entries[0].index)
