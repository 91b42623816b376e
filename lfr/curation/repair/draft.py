"""A dataset being mended aside: links to the original's files, and new files in place of some."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from lfr.curation.contents import Contents
from lfr.data.tables import files_below


class Unmendable(Exception):
    """What cannot be mended without guessing; the message says why, if it is not said before."""


@dataclass(frozen=True)
class Repair:
    """One thing that is mended.

    Attributes:
        file: relative to the dataset's folder.
        what: in words.
        places: how many episodes, rows or features it concerns.
        unit: which of these.
    """

    file: str
    what: str
    places: int = 1
    unit: str = "episode"

    def __str__(self) -> str:
        """One line for a terminal."""
        if not self.unit:
            return f"{self.file}: {self.what}"
        return f"{self.file}: {self.what} ({self.places} {self.unit}{'s' * (self.places != 1)})"


@dataclass
class Draft:
    """What will be the mended dataset.

    Attributes:
        path: its folder.
        repairs: what has been mended, in order.
        reasons: why something has not.
        changed: the files that are not the original's any more, relative to `path`, in the order
            in which they were first replaced.
    """

    path: Path
    repairs: list[Repair] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, dataset: Path, folder: Path) -> Draft:
        """Link every file of `dataset` in the empty `folder`."""
        root, folder = dataset.resolve(), folder.resolve()
        for file in files_below(root, ""):
            place = folder / file.relative_to(root)
            place.parent.mkdir(parents=True, exist_ok=True)
            if leads_out(file, root):  # as it is: verifying says so of it here as there
                place.symlink_to(os.readlink(file))
            else:  # relative, as those of the Hub's store, about which nothing is said
                place.symlink_to(os.path.relpath(file, place.parent))
        return cls(folder)

    def contents(self) -> Contents:
        """The dataset as it is mended so far, read anew."""
        return Contents.open(self.path)

    @contextmanager
    def replaced(self, file: str) -> Iterator[Path]:
        """Where to write what comes in the place of a file; nothing is there yet."""
        place = self.path / file
        place.parent.mkdir(parents=True, exist_ok=True)
        new = place.with_name(f".new-{place.name}")
        try:
            yield new
            new.replace(place)
        finally:
            new.unlink(missing_ok=True)
        if file not in self.changed:
            self.changed.append(file)

    def mended(self, file: str, what: str, places: int = 1, unit: str = "episode") -> None:
        """Note what has been mended."""
        self.repairs.append(Repair(file, what, places, unit))

    def not_mended(self, reason: object) -> None:
        """Note why something has not been, once."""
        if str(reason) and str(reason) not in self.reasons:
            self.reasons.append(str(reason))


def leads_out(file: Path, root: Path) -> bool:
    """Whether this is a link by an absolute path to somewhere outside of the folder `root`."""
    linked = file.is_symlink() and os.path.isabs(os.readlink(file))
    return linked and not file.resolve().is_relative_to(root)
