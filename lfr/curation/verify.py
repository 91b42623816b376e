"""All checks of a dataset, one after the other, none of which stops the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from lfr.artifacts import as_json
from lfr.curation.checks.behaviour import check_behaviour
from lfr.curation.checks.counts import check_counts
from lfr.curation.checks.files import check_files
from lfr.curation.checks.logs import check_logs, default_folder, has_logs
from lfr.curation.checks.order import check_order, check_tasks, check_time
from lfr.curation.checks.pictures import check_pictures
from lfr.curation.checks.schema import check_schema
from lfr.curation.checks.seeds import check_seeds
from lfr.curation.checks.statistics import check_statistics
from lfr.curation.checks.values import check_values
from lfr.curation.checks.videos import check_videos
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding, Unreadable
from lfr.curation.scores import Score, episode_lengths, scores
from lfr.data.source import Fault, source_of
from lfr.errors import DataError
from lfr.progress import progress

Check = Callable[[Contents], Iterable[Finding]]

CHECKS: dict[str, Check] = {
    "files": check_files,
    "schema": check_schema,
    "counts": check_counts,
    "order": check_order,
    "time": check_time,
    "tasks": check_tasks,
    "values": check_values,
    "statistics": check_statistics,
    "videos": check_videos,
    "seeds": check_seeds,
    "behaviour": check_behaviour,
}


@dataclass(frozen=True)
class Report:
    """What came of verifying a dataset.

    Attributes:
        path: the dataset's folder.
        findings: in the order of the checks.
        episodes, frames: as info.json counts them.
        not_checked: what could not be looked at, and why; nothing is wrong with it.
        lengths: frames of each episode, as meta/episodes has it; none where that cannot be read.
        accepted: findings that are known, and set aside (`lfr.curation.accepted`).
        unmatched: which accepted ones are not found any more, in a line; "" where all are.
        contents: what was looked at, for those who show it.
    """

    path: Path
    findings: tuple[Finding, ...]
    episodes: int = 0
    frames: int = 0
    not_checked: tuple[str, ...] = field(default=())
    lengths: tuple[int, ...] = ()
    accepted: tuple[Finding, ...] = ()
    unmatched: str = ""
    contents: Contents | None = field(default=None, compare=False, repr=False)

    @property
    def errors(self) -> list[Finding]:
        return [finding for finding in self.findings if finding.severity == "error"]

    @property
    def warnings(self) -> list[Finding]:
        return [finding for finding in self.findings if finding.severity == "warning"]

    @property
    def scores(self) -> list[Score]:
        """Of every episode, in order."""
        return scores(self.findings, self.lengths)

    def __str__(self) -> str:
        """The last line."""
        known = f", {len(self.accepted)} accepted" if self.accepted else ""
        rest = f"; not checked: {', '.join(self.not_checked)}" if self.not_checked else ""
        return (
            f"{self.path}: {self.episodes} episodes, {self.frames} frames: "
            f"{_count(self.errors, 'error')}, {_count(self.warnings, 'warning')}{known}{rest}"
        )

    def as_json(self) -> dict[str, Any]:
        return {
            "path": str(self.path),
            "episodes": self.episodes,
            "frames": self.frames,
            "errors": len(self.errors),
            "warnings": len(self.warnings),
            "not_checked": list(self.not_checked),
            "findings": [finding.as_json() for finding in self.findings],
            "accepted": [finding.as_json() for finding in self.accepted],
            "unmatched": self.unmatched,
            "scores": as_json(self.scores),
        }


def verify_dataset(path: Path, logs: Path | None = None, pictures: int | None = None) -> Report:
    """Check a LeRobot v3.0 dataset for all that can be wrong with it.

    Args:
        path: the dataset's folder, or what `lfr.data.opening.opened` gave of one; nothing is
            written to it.
        logs: the folder of the logs it was packed from; by default `data/logs/<name>` beside a
            dataset `data/lerobot/<name>`, where that is.
        pictures: every how many frames of its videos one is decoded and looked at; None leaves
            them.

    Raises:
        DataError: there is no LeRobot v3.0 dataset at `path`, or no folder `logs`.
    """
    source = source_of(Path(path))
    name = Path(source.name)
    if logs is not None and not logs.is_dir():
        raise DataError("no such folder of logs", file=logs)
    try:
        contents = Contents.open(source.path)
    except Unreadable as unreadable:
        return Report(name, (unreadable.finding,))
    logs = logs or default_folder(source.origin)
    checks: dict[str, Check] = {**CHECKS, "logs": partial(check_logs, folder=logs)}
    if pictures is not None:
        checks["pictures"] = partial(check_pictures, stride=pictures)
    findings: dict[Finding | str, Finding] = {}
    bar = progress(checks.items(), f"verify {name.name}", "check")
    of_checks = (finding for _, check in bar for finding in _all(check, contents))
    for finding in chain(map(_of_fault, source.faults), of_checks):
        said = replace(finding, file=source.said(finding.file, finding.column),
                       message=source.said(finding.message))  # fmt: skip
        findings.setdefault(str(said), said)  # a file that two checks cannot read
    totals = [contents.info.get(name) for name in ("total_episodes", "total_frames")]
    episodes, frames = (total if isinstance(total, int) else 0 for total in totals)
    return Report(
        name, tuple(findings.values()), episodes, frames, tuple(_not_checked(contents, logs)),
        lengths=episode_lengths(contents), contents=contents,
    )  # fmt: skip


def _of_fault(fault: Fault) -> Finding:
    return Finding(fault.check, fault.message, file=fault.file, found=fault.found,
                   expected=fault.expected, places=fault.places)  # fmt: skip


def _all(check: Check, contents: Contents) -> Iterator[Finding]:
    try:
        yield from check(contents)
    except Unreadable as unreadable:
        yield unreadable.finding


def _not_checked(contents: Contents, logs: Path | None) -> Iterator[str]:
    try:
        named = has_logs(contents)
    except Unreadable:
        return
    if not named:
        yield "logs (the episodes name none)"
    elif logs is None:
        yield "logs (not there; --logs DIR)"


def _count(findings: list[Finding], word: str) -> str:
    return f"{len(findings) or 'no'} {word}{'' if len(findings) == 1 else 's'}"
