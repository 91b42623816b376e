"""What `lfr verify --json` printed, as a report again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lfr.artifacts import read_json
from lfr.curation.finding import Finding
from lfr.curation.verify import Report
from lfr.errors import DataError


def read_report(file: Path) -> Report:
    """The report in a file.

    Raises:
        DataError: no such file, or another content.
    """
    content = read_json(file)
    parts: dict[str, list[Any]] = {}
    for name in ("findings", "accepted", "scores"):
        part = content.get(name) if isinstance(content, dict) else None
        if not isinstance(part, list):
            raise DataError("no report of a dataset", file=file, found=f"no list of {name}",
                            expected="what lfr verify --json prints")  # fmt: skip
        parts[name] = part
    lengths = tuple(_frames(each, file) for each in parts["scores"])
    return Report(
        Path(str(content.get("path", ""))),
        tuple(Finding.from_json(each, file) for each in parts["findings"]),
        episodes=len(lengths),
        frames=sum(lengths),
        lengths=lengths,
        accepted=tuple(Finding.from_json(each, file) for each in parts["accepted"]),
    )


def _frames(score: Any, file: Path) -> int:
    frames = score.get("frames") if isinstance(score, dict) else None
    if type(frames) is not int:
        raise DataError("a score without frames", file=file, found=str(score)[:100],
                        expected="what lfr verify --json prints")  # fmt: skip
    return frames
