"""Publishing to a folder: what the Hub would hold, written whole."""

from __future__ import annotations

import shutil
from pathlib import Path

from lfr.artifacts import read_json, write_whole
from lfr.errors import DataError
from lfr.hub.model_facts import CONFIG, STAGES
from lfr.hub.publication import CARD, INFO, Publication


def publish_to_folder(publication: Publication, folder: Path) -> None:
    """Write a publication to a folder; an earlier one there is replaced at the end.

    Raises:
        DataError: the folder holds anything but an earlier publication of this kind.
    """
    folder = Path(folder)
    folder = folder.resolve() if folder.is_symlink() else folder
    if folder.exists() and not folder.is_dir():
        raise DataError("a file is in the way", file=folder, expected="a folder, or nothing")
    if folder.is_dir():
        _refuse_other_things(publication, folder)
    with write_whole(folder) as partial:
        for path, content in publication.files.items():
            target = partial / path
            target.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, bytes):
                target.write_bytes(content)
            else:
                shutil.copyfile(content, target)


def _refuse_other_things(publication: Publication, folder: Path) -> None:
    """A folder is replaced as a whole, so nothing may be in it that would be missed."""
    there = {
        file.relative_to(folder).as_posix(): file
        for file in sorted(folder.rglob("*"))
        if file.is_file() or file.is_symlink()
    }
    for path, file in there.items():
        if not (path == CARD or path in publication.files or publication.ours.fullmatch(path)):
            raise DataError(
                "the folder holds other things; name an empty one",
                file=file,
                expected="nothing, or an earlier publication",
            )
    if there and not _is_earlier(publication, there):
        raise DataError(
            "the folder holds other things; name an empty one",
            file=folder,
            found=", ".join(list(there)[:3]),
            expected=f"nothing, or an earlier publication with its {CARD}",
        )


def _is_earlier(publication: Publication, there: dict[str, Path]) -> bool:
    """Whether a card and files named as ours are a publication, not somebody's project."""
    if CARD not in there:
        return False
    if publication.kind == "dataset":
        return INFO in there
    configs = [file for path, file in there.items() if Path(path).name == CONFIG]
    return all(_kind(file) in STAGES for file in configs)


def _kind(config: Path) -> str | None:
    try:
        content = read_json(config)
    except DataError:
        return None
    kind = content.get("kind") if isinstance(content, dict) else None
    return kind if isinstance(kind, str) else None
