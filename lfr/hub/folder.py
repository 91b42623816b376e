"""Publishing to a folder: what the Hub would hold, written whole."""

from __future__ import annotations

import shutil
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import DataError
from lfr.hub.publication import CARD, Publication


def publish_to_folder(publication: Publication, folder: Path) -> None:
    """Write a publication to a folder; an earlier one there is replaced at the end.

    Raises:
        DataError: the folder holds a file that no publication of this kind put there.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise DataError("a file is in the way", file=folder, expected="a folder, or nothing")
    for file in sorted(folder.rglob("*")) if folder.is_dir() else ():
        path = file.relative_to(folder).as_posix()
        known = path == CARD or path in publication.files or publication.ours.fullmatch(path)
        if file.is_file() and not known:
            raise DataError(
                "the folder holds other things; name an empty one",
                file=file,
                expected="nothing, or an earlier publication",
            )
    with write_whole(folder) as partial:
        for path, content in publication.files.items():
            target = partial / path
            target.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, bytes):
                target.write_bytes(content)
            else:
                shutil.copyfile(content, target)
