"""Parts of a page that a program writes, each between markers of its name."""

from __future__ import annotations

from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import DataError


def put(page: Path, name: str, text: str) -> None:
    """Put ``text`` between a page's markers ``<!-- name -->`` and ``<!-- /name -->``.

    Raises:
        DataError: the markers are not there, or not once each and in order.
    """
    before, now, after = _split(page, name)
    if now == text:
        return
    with write_whole(page) as partial:
        partial.write_text(f"{before}\n{text}\n{after}", encoding="utf-8")


def shown(page: Path, name: str) -> str:
    """What a page shows between its markers, as `put` put it there; raises as that does."""
    return _split(page, name)[1]


def _split(page: Path, name: str) -> tuple[str, str, str]:
    """What is before, its marker included; what is between; what is after, its marker included."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    text = page.read_text(encoding="utf-8")
    found = [text.count(marker) for marker in (begin, end)]
    if found != [1, 1] or text.index(end) < text.index(begin):
        raise DataError(
            "the markers are not there once each",
            file=page, found=found, expected=f"one {begin} and, after it, one {end}",
        )  # fmt: skip
    before, rest = text.split(begin)
    between, after = rest.split(end)
    return before + begin, between.strip("\n"), end + after
