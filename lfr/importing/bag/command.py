"""`lfr import BAG ... --mapping FILE --to FOLDER`, the part of it that is for bags."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lfr.errors import ParameterError

MOST_SHOWN = 20  # lines of one kind


def run_import(bags: Sequence[Path], mapping: Path | None, out: Path) -> None:
    """Import bags, and print what came of it.

    Raises:
        LfrError: a bag that cannot be imported, a mapping that does not fit, or no free folder.
    """
    from lfr.importing.bag.dataset import import_bags
    from lfr.importing.bag.mapping import read_mapping

    if mapping is None:
        raise ParameterError(f"a bag needs --mapping; `lfr columns {bags[0]}` proposes one")
    found = import_bags(bags, out, read_mapping(mapping))
    for line in _shown([*found.refused, *found.notes]):
        print(line)
    print(f"time: {found.clock}")
    for lag in found.lags:
        print(lag)
    for finding in _shown(list(map(str, found.report.findings))):
        print(finding)
    refused = f", {len(found.refused)} refused" if found.refused else ""
    print(f"{out}: {found.episodes} episodes, {found.frames} frames{refused}")


def _shown(lines: Sequence[str]) -> list[str]:
    more = len(lines) - MOST_SHOWN
    return [*lines[:MOST_SHOWN], *([f"and {more} more, in meta/source.json"] if more > 0 else [])]
