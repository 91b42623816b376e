"""A dataset as its readers want it, in LeRobot v3.0's form, whatever version it has and wherever
it lies.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from lfr.artifacts import parse_json
from lfr.data.older import older_version, write_as_v30
from lfr.data.repository import Repository, parse_name
from lfr.data.source import VERSION, Source, known
from lfr.errors import DataError, LfrError


@contextmanager
def opened(path: Path, revision: str | None = None, *, verify: bool = False) -> Iterator[Path]:
    """The folder to read a dataset from; until the end, of v2.1 or of the Hub, a temporary one.

    That holds metadata of v3.0 and links to the rest, and errors that it leads to say the names of
    the dataset itself. Whatever else is at `path` is its own folder or file.

    Args:
        path: of a folder; where there is none, `owner/name` is a dataset's on the Hub, and
            `owner/name@revision` that of a branch, tag or commit.
        revision: the same, given by itself.
        verify: all files are wanted, and of what is wrong in v2.1's metadata nothing is raised.

    Raises:
        LfrError: the Hub has no such dataset, or it cannot be reached; metadata of v2.1 that
            cannot be read.
    """
    remote = None if path.exists() else parse_name(path.as_posix())
    if revision is not None and (remote is None or remote[1] is not None):
        raise LfrError(f"--revision {revision} is of a dataset on the Hub; expected owner/name, "
                       f"found {path}")  # fmt: skip
    repository = None if remote is None else Repository.find(remote[0], revision or remote[1])
    origin = path if repository is None else repository.folder
    info = _info(origin)
    version = older_version(origin, info) or VERSION
    if repository is None and version == VERSION:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="lfr-") as name:
        called = (path.resolve() if repository is None else Path(repository.name)).name
        folder = Path(name).resolve() / (called or "dataset")
        folder.mkdir()
        for part in ("data", "videos", "images"):
            if repository is not None and verify:
                repository.fetch(part)
            (folder / part).symlink_to(origin.resolve() / part)
        faults = []
        if version == VERSION:
            (folder / "meta").symlink_to(origin / "meta")
        else:
            faults = write_as_v30(origin, folder, info, version, stats=verify)
        source = Source(folder, origin, str(path), version, tuple(faults))
        if repository is not None:
            source = replace(source, repository=repository.name, fetch=repository.fetch)
        with known(source):
            for fault in faults:
                if fault.fatal and not verify:
                    raise DataError(fault.message, file=folder / fault.file, found=fault.found,
                                    expected=fault.expected)  # fmt: skip
            yield folder


def _info(path: Path) -> Any:
    """What info.json holds; whoever reads the dataset says what is wrong with it."""
    try:
        return parse_json((path / "meta" / "info.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
