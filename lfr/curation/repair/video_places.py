"""Where each episode's pictures are: placed anew where the files' frames leave one way to do so."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lfr.curation.checks.order import TOLERANCE_S
from lfr.curation.contents import Contents
from lfr.curation.mp4 import BrokenVideoError, read_header
from lfr.curation.repair.draft import Unmendable
from lfr.curation.repair.episode_rows import numbers_of
from lfr.data.tables import files_below

NAMES = ("chunk_index", "file_index", "from_timestamp", "to_timestamp")


def video_places(
    contents: Contents, table: pa.Table, lengths: NDArray[np.int64], key: str
) -> dict[str, Any]:
    """The columns of meta/episodes that say where a camera's pictures are.

    Nothing where those that are there can be right. Else the episodes are laid one after the
    other into the files, which has to fill every file exactly, and to be the order in which they
    were.

    Returns:
        `videos/<key>/...` -> (E,).

    Raises:
        Unmendable: there is no one way.
    """
    stored = np.stack([numbers_of(table, f"videos/{key}/{name}") for name in NAMES])  # (4, E)
    frames: dict[tuple[int, int], int] = {}
    broken: list[str] = []
    for file in files_below(contents.path / "videos" / key, ".mp4"):
        place = _place(contents, key, file)
        try:
            header = read_header(file)
        except (BrokenVideoError, OSError):
            broken.append(contents.relative(file))
            continue
        off = np.abs(header.times - np.arange(header.frames) / contents.fps)
        if place is None or (off > 0.5 / contents.fps).any():
            broken.append(contents.relative(file))
            continue
        frames[place] = header.frames
    if not frames and not broken:
        return {}  # missing: said where files are checked
    if _possible(stored, frames, lengths, contents.fps, bool(broken)):
        return {}
    named = {(int(c), int(f)) for c, f in stored[:2].T if np.isfinite([c, f]).all()}
    for files in (sorted(named & frames.keys()), sorted(frames)):
        filled = _fill({place: frames[place] for place in files}, lengths, contents.fps)
        if filled is not None and not broken:
            break
    else:
        raise Unmendable(
            f"the places of the pictures of {key}: the episodes' {lengths.sum()} rows do not fill "
            f"its files exactly, which have {sum(frames.values())} frames"
            f"{f', and {broken[0]} is broken or of another rate' if broken else ''}"
        )
    if _in_another_order(stored):
        raise Unmendable(f"the places of the pictures of {key}: the episodes are in no order there")
    return {f"videos/{key}/{name}": values for name, values in zip(NAMES, filled, strict=True)}


def _place(contents: Contents, key: str, file: Path) -> tuple[int, int] | None:
    found = re.fullmatch(r"chunk-(\d+)/file-(\d+)", f"{file.parent.name}/{file.stem}")
    if not found:
        return None
    chunk, number = int(found[1]), int(found[2])
    name = contents.named("video_path", video_key=key, chunk_index=chunk, file_index=number)
    return (chunk, number) if name == contents.relative(file) else None


def _possible(
    stored: NDArray, frames: dict[tuple[int, int], int], lengths: NDArray, fps: float, broken: bool
) -> bool:
    """Whether the episodes are within their files, of their lengths, and none over another."""
    if not np.isfinite(stored).all():
        return False
    chunk, file, start, end = stored
    first, last = np.rint(start * fps), np.rint(end * fps)
    if (last - first != lengths).any() or (np.abs(start * fps - first) > TOLERANCE_S * fps).any():
        return False
    for place in set(zip(chunk.tolist(), file.tolist(), strict=True)):
        if place not in frames:
            if broken:
                continue  # said where videos are checked
            return False
        inside = np.flatnonzero((chunk == place[0]) & (file == place[1]))
        order = inside[np.argsort(first[inside], kind="stable")]
        if last[order[-1]] > frames[place] or (first[order][1:] < last[order][:-1]).any():
            return False
    return True


def _fill(
    frames: dict[tuple[int, int], int], lengths: NDArray[np.int64], fps: float
) -> tuple[NDArray, ...] | None:
    """The columns, with the episodes laid one after the other; None where they do not fit."""
    ends = np.cumsum(lengths)
    limits = np.cumsum(list(frames.values()))
    if not len(limits) or limits[-1] != ends[-1] or not np.isin(limits, ends).all():
        return None
    at = np.searchsorted(limits, ends, side="left")
    first = ends - lengths - (limits - list(frames.values()))[at]
    chunk, file = np.array(list(frames)).T
    return chunk[at], file[at], first / fps, (first + lengths) / fps


def _in_another_order(stored: NDArray) -> bool:
    """Whether the places that are there go back more often than single mistakes do."""
    known = stored[:3, np.isfinite(stored[:3]).all(axis=0)].T.tolist()
    back = sum(later < earlier for earlier, later in pairwise(known))
    return back > max(1, len(known) // 4)
