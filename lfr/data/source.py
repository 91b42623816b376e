"""Where an open dataset came from: its folder as it is, or a copy of its metadata in v3.0's form.

`lfr.data.opening.opened` makes such copies; they are known here, by their folder, while they are
open, so that whoever reads one by its path can say what it was and have files of it fetched.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.errors import DataError, LfrError

VERSION = "v3.0"

_open: dict[Path, Source] = {}


@dataclass(frozen=True)
class Fault:
    """What is wrong with metadata of an older version, as `lfr verify` would say it.

    Attributes:
        check, message, file, found, expected, places: as of `lfr.curation.finding.Finding`.
        fatal: whether nothing but `lfr verify` can go on.
    """

    check: str
    message: str
    file: str
    found: Any = None
    expected: Any = None
    places: int = 1
    fatal: bool = True


def _nothing(place: str) -> None:
    pass


@dataclass(frozen=True)
class Source:
    """A dataset that is open.

    Attributes:
        path: the folder to read it from, in v3.0's form.
        origin: the folder that its files are in.
        name: what whoever asked for it called it.
        version: that its files have.
        faults: what of its metadata is not as its own version has it.
        repository: its name on the Hub, `owner/name`; "" where it is not from there.
        fetch: to be called with a file or folder below `path` before that is read.
    """

    path: Path
    origin: Path
    name: str
    version: str = VERSION
    faults: tuple[Fault, ...] = ()
    repository: str = ""
    fetch: Callable[[str], None] = _nothing

    @property
    def is_older(self) -> bool:
        return self.version != VERSION

    def is_named(self, text: str) -> bool:
        """Whether a text has a folder in it that whoever asked for the dataset does not know."""
        folders = [self.path, *([self.origin] if self.repository else [])]
        return any(str(folder) in text for folder in folders)

    def said(self, text: str, column: str | None = None) -> str:
        """A text with the dataset's own names in it, in the place of the copy's.

        Args:
            column: of meta/episodes, that the text is about.
        """
        for folder in (self.path, self.origin):
            text = text.replace(str(folder), self.name)
        if not self.is_older:
            return text
        of_statistics = (column or "").startswith("stats/")
        for pattern, name in (
            (r"meta/episodes(?![\w.])(/[\w/-]+\.parquet)?",
             "meta/episodes_stats.jsonl" if of_statistics else "meta/episodes.jsonl"),
            (r"meta/tasks\.parquet", "meta/tasks.jsonl"),
            (r"meta/stats\.json\b",
             "meta/stats.json" if self.version == "v2.0" else "meta/episodes_stats.jsonl"),
        ):  # fmt: skip
            text = re.sub(pattern, name, text)
        return text


def source_of(path: Path) -> Source:
    """What is known of the dataset in a folder: that it is what it is, where nothing else is."""
    return _open.get(path) or Source(path, path, str(path))


@contextmanager
def known(source: Source) -> Iterator[Path]:
    """Have a source known by its folder, and errors about it say its own names."""
    _open[source.path] = source
    try:
        yield source.path
    except LfrError as error:
        if not source.is_named(str(error)):
            raise  # another dataset's, that is open at the same time
        error.args = (source.said(str(error)), *error.args[1:])
        if isinstance(error, DataError):
            error.file = Path(source.said(str(error.file)))
        raise
    finally:
        del _open[source.path]
