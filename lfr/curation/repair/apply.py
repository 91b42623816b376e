"""The mended dataset's files put where they belong: in a new folder, or in the place of the old."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.curation.contents import EPISODES, INFO, STATS, TASKS
from lfr.curation.repair.draft import Draft, leads_out
from lfr.data.tables import files_below
from lfr.errors import LfrError

# Rows first, info.json last: what is left by a kill in between is mended by the same steps.
ORDER = ("data/", TASKS, EPISODES, STATS, INFO)


def backup_of(path: Path) -> Path:
    """Where the old files of the dataset at `path` are kept."""
    whole = Path(os.path.abspath(path))  # of "." too; a link keeps its own name
    return whole.with_name(f"{whole.name}.before-fix")


def check_new(path: Path, out: Path) -> None:
    """Raises LfrError where a mended copy of `path` cannot be written as `out`."""
    if out.exists() or out.is_symlink():
        raise LfrError(f"{out} is there already; expected a new folder")
    if out.resolve().is_relative_to(path.resolve()):
        raise LfrError(f"{out} is within {path}; expected a folder outside of it")


def check_in_place(path: Path) -> None:
    """Raises LfrError where old files of `path` are kept already."""
    backup = backup_of(path)
    if backup.exists() or backup.is_symlink():
        raise LfrError(
            f"{backup} is there already, with the files that an earlier repair has replaced; "
            "move or remove it first"
        )


def write_new(draft: Draft, out: Path) -> None:
    """Copy every file of the draft to `out`; links by absolute paths stay links."""
    root = draft.path.resolve()
    with write_whole(out) as partial:
        partial.mkdir()
        for file in files_below(root, ""):
            place = partial / file.relative_to(root)
            place.parent.mkdir(parents=True, exist_ok=True)
            if not file.exists():
                continue  # a link to nothing
            if leads_out(file, root):
                place.symlink_to(os.readlink(file))
            elif file.is_file():
                shutil.copyfile(file, place)


def replace_in_place(draft: Draft, path: Path) -> Path:
    """Replace the files of `path` that the draft has changed, one at a time.

    Each old file is kept before the new one takes its name, both whole. Where an earlier attempt
    was killed, the files that it kept are the old ones, and stay.

    Returns:
        The folder with the old files.

    Raises:
        LfrError: that is there already.
    """
    check_in_place(path)
    backup = backup_of(path)
    kept = _unfinished(backup)
    for file in sorted(draft.changed, key=_place):
        old = path / file
        if old.exists() and not (kept / file).exists():
            with write_whole(kept / file) as partial:
                _keep(old, partial)
        with write_whole(old) as partial:
            shutil.copyfile(draft.path / file, partial)
    kept.mkdir(parents=True, exist_ok=True)  # where all files were lost ones
    kept.rename(backup)
    return backup


def end_unfinished(path: Path) -> Path | None:
    """Give the old files of a repair that was killed after its last file their folder's name."""
    backup = backup_of(path)
    if not _unfinished(backup).is_dir():
        return None
    check_in_place(path)
    return _unfinished(backup).rename(backup)


def _unfinished(backup: Path) -> Path:
    return backup.with_name(f".partial-{backup.name}")


def _place(file: str) -> int:
    return next(i for i, start in enumerate(ORDER) if file.startswith(start))


def _keep(old: Path, place: Path) -> None:
    if not old.is_symlink():
        try:
            os.link(old, place)
            return
        except OSError:  # another file system, or one without links
            pass
    shutil.copyfile(old, place)
