"""Files that are missing, unfinalized, cut off, left over, or not where the episodes say."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from lfr.artifacts import files_below
from lfr.curation.contents import STATS, TASKS, Contents
from lfr.curation.finding import Finding, Unreadable
from lfr.data.older import EPISODES_STATS, V21


def check_files(contents: Contents) -> Iterator[Finding]:
    """Every Parquet file can be opened, and those that episodes name are all there are."""
    for file in (*contents.episode_files, *contents.data_files):
        try:
            contents.opened(file)
        except Unreadable as unreadable:
            of_file = contents.episodes_in(contents.relative(file))
            yield replace(unreadable.finding, episodes=of_file)
    if not (contents.path / TASKS).is_file():
        yield Finding("missing-file", "not there", file=TASKS)
    folder = contents.source.origin
    stats = EPISODES_STATS if contents.source.version == V21 else STATS
    if not (folder / stats).is_file():
        yield Finding("missing-file", "no statistics; a policy cannot normalize", "warning", stats)
    if any((folder / "images").rglob("*.png")) and not contents.pictures("image"):
        yield Finding(
            "left-over", "pictures that were never made into video: a recording was interrupted",
            "warning", "images",
        )  # fmt: skip
    unfinished = {*folder.rglob("*.partial"), *folder.rglob(".partial-*")}
    for partial in sorted(unfinished):
        name = partial.relative_to(folder).as_posix()
        yield Finding("left-over", "an unfinished file", "warning", name)
    yield from _links(folder)
    yield from _named(contents, "data", {contents.relative(file) for file in contents.data_files})
    videos = [contents.relative(f) for f in files_below(contents.path / "videos", ".mp4")]
    for key in contents.pictures():
        of_key = {name for name in videos if key in name.split("/")}
        yield from _named(contents, f"videos/{key}", of_key)


def _links(folder: Path) -> Iterator[Finding]:
    """Links to files elsewhere: whoever publishes or copies the dataset takes these along.

    Not those of a store of files by their content, as the Hugging Face Hub's and DVC's are.
    """
    root = folder.resolve()
    for file in sorted(folder.rglob("*")):
        if not (file.is_symlink() and os.path.isabs(os.readlink(file))):
            continue
        target = file.resolve()
        if not target.is_relative_to(root) and not {"blobs", "files", ".dvc"} & set(target.parts):
            yield Finding("link", "a link that leads out of the dataset", "warning",
                          file.relative_to(folder).as_posix(), found=str(target))  # fmt: skip


def _named(contents: Contents, folder: str, found: set[str]) -> Iterator[Finding]:
    """The files that are there against those that the episodes name."""
    expected = contents.placed_in(folder)
    for name in sorted(set(expected) - found):
        yield Finding(
            "missing-file", "episodes name a file that is not there", file=name,
            column=f"{folder}/file_index", places=len(expected[name]),
            episodes=tuple(expected[name].tolist()),
        )  # fmt: skip
    for name in sorted(found - set(expected)):
        yield Finding("left-over", "a file that no episode names", "warning", name)
    most = contents.info.get("chunks_size")
    if isinstance(most, int) and expected:
        pairs = set(zip(*(each.tolist() for each in contents.placed(folder)), strict=True))
        chunks, sizes = np.unique([chunk for chunk, _ in pairs], return_counts=True)
        for i in np.flatnonzero(sizes > most):
            yield Finding(
                "counts", "more files in a chunk than chunks_size", "warning",
                file=f"{folder}/chunk-{int(chunks[i]):03d}", found=int(sizes[i]), expected=most,
            )  # fmt: skip
