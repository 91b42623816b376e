"""Words out of a dataset as HTML and Markdown that show them and obey none of them."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

import numpy as np

from lfr.curation.finding import Finding, short

LONGEST = 24  # ranges of episodes that are written out
UNSHOWN = "\N{REPLACEMENT CHARACTER}"


def escaped(text: object) -> str:
    """Text for HTML, within an element or a quoted attribute."""
    return html.escape(_printable(str(text)), quote=True)


def code(text: object) -> str:
    """Text for Markdown: nothing in it is a link, a mention or a tag."""
    words = " ".join(_printable(str(text)).split()).replace("`", "'")
    return f"`{words or ' '}`"


def cell(text: object) -> str:
    """The same within a table."""
    return code(text).replace("|", "\\|")


def ranges(numbers: Iterable[int], most: int = LONGEST) -> str:
    """`3, 7-9`: whole numbers that rise, as `lfr edit` takes them; so many pieces of it."""
    array = np.array(list(numbers), np.int64)
    if not len(array):
        return ""
    pieces = np.split(array, np.flatnonzero(np.diff(array) != 1) + 1)
    words = [f"{p[0]}" if len(p) == 1 else f"{p[0]}-{p[-1]}" for p in pieces[:most]]
    rest = sum(map(len, pieces[most:]))
    return ", ".join(words) + (f" and {rest} more" if rest else "")


def by_kind(findings: Sequence[Finding]) -> dict[str, list[Finding]]:
    """The findings of each kind: errors first, then as the checks gave them."""
    kinds: dict[str, list[Finding]] = {}
    for finding in sorted(findings, key=lambda one: one.severity != "error"):
        kinds.setdefault(finding.check, []).append(finding)
    return kinds


def episodes_of(findings: Iterable[Finding]) -> list[int]:
    """All that they are about, from the lowest."""
    return sorted({episode for finding in findings for episode in finding.episodes})


def places(finding: Finding) -> dict[str, str]:
    """Where it is and what was found there, by name, in words."""
    named = {
        "file": finding.file or None,
        "episode": finding.episode,
        "column": finding.column or None,
        "row": finding.row if finding.frames is None else None,
        "frames": "{} to {}".format(*finding.frames) if finding.frames else None,
        "found": finding.found,
        "expected": finding.expected,
        "places": finding.places if finding.places > 1 else None,
    }
    words = {name: short(value) for name, value in named.items() if value is not None}
    if len(finding.episodes) > 1:
        words["episodes"] = ranges(finding.episodes)
    return words


def _printable(text: str) -> str:
    """Control characters and halves of surrogate pairs, which no file may hold, made visible."""
    return "".join(c if c.isprintable() or c in "\n\t" else UNSHOWN for c in text)
