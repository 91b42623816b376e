"""All checks of MCAP logs: of each alone, and of the logs of one folder against each other."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lfr.artifacts import file_hash
from lfr.curation.checks.recorded import check_container, check_foreign, check_log
from lfr.curation.finding import Finding
from lfr.curation.verify import Report
from lfr.data.episode import Episode
from lfr.data.log_checks import LogKind
from lfr.data.log_reader import read_log
from lfr.errors import DataError, LfrError
from lfr.progress import progress
from lfr.seeds import use_of_seed


def has_logs(path: Path) -> bool:
    """Whether there are logs at a path, or a file that should be one, and no dataset."""
    if path.is_dir():
        return not (path / "meta" / "info.json").is_file() and any(path.glob("*.mcap*"))
    return path.is_file()


def verify_logs(path: Path, pictures: int | None = None) -> Report:
    """Check logs for all that can be wrong with them.

    Args:
        path: a log, or the folder of an arm's logs; nothing is written.
        pictures: every how many frames of a camera one is decoded; None leaves them.

    Raises:
        DataError: a file that is no MCAP file.
    """
    folder = path if path.is_dir() else path.parent
    logs = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    findings: list[Finding] = []
    if path.is_dir():
        for unfinished in sorted(path.glob("*.mcap.partial")):
            findings.append(Finding("left-over", "an unfinished log; `lfr recover` mends it",
                                    "warning", unfinished.name))  # fmt: skip
    seen = _Seen(folder)
    episodes = frames = 0
    for number, log in enumerate(progress(logs, f"verify {path.resolve().name}", "log")):
        where: dict[str, Any] = {"file": log.name}
        if path.is_dir():
            where["episode"] = number
        try:
            container = check_container(log, where)
        except DataError as error:
            if not path.is_dir():
                raise
            findings.append(_of_error(error, "damaged-file", where))
            continue
        findings += container.findings
        if not container.is_ours:
            findings += check_foreign(container, where)
        elif container.is_whole:
            try:
                episode = read_log(log)
            except DataError as error:
                findings.append(_of_error(error, "log", where))
                continue
            episodes, frames = episodes + 1, frames + len(episode)
            findings += check_log(episode, container, where, pictures)
            findings += seen.compared(episode, log, number, where)
    return Report(path, tuple(findings), episodes, frames)


def _of_error(error: DataError, check: str, where: dict[str, Any]) -> Finding:
    said = {name: None if value is None else str(value)
            for name, value in (("found", error.found), ("expected", error.expected))}  # fmt: skip
    return Finding(check, error.message.partition("; record")[0], column=error.column,
                   **said, **where)  # fmt: skip


class _Seen:
    """What the logs of a folder have been, to compare the next one with."""

    def __init__(self, folder: Path) -> None:
        self._kind: LogKind | None = None
        self._hashes: dict[str, str] = {}
        self._starts: dict[tuple[str, str, int], str] = {}

    def compared(
        self, episode: Episode, log: Path, number: int, where: dict[str, Any]
    ) -> Iterator[Finding]:
        """What is wrong with a log as one of a folder's."""
        if self._kind is None:
            fps = episode.metadata.get("fps", 0)
            self._kind = LogKind(log, episode, tuple(episode.images), fps)
        try:
            self._kind.check_kind(episode, log, number)
        except DataError as error:
            yield _of_error(error, "log", where)
        if (other := self._hashes.setdefault(file_hash(log), log.name)) != log.name:
            yield Finding("log", f"the same log as {other}", **where)
            return
        try:
            use = use_of_seed(episode.seed)
        except LfrError:
            use = "no"
        if use != "demonstration":
            yield Finding("leaked-seed", f"a seed of {use} episodes, not to be learned from",
                          "warning", column="seed", found=episode.seed, **where)  # fmt: skip
        start = (episode.robot, episode.task, episode.seed)
        if (other := self._starts.setdefault(start, log.name)) != log.name:
            yield Finding("repeated-seed", "the same start as another log's", "warning",
                          column="seed", found=episode.seed, expected=f"another than {other}'s",
                          **where)  # fmt: skip
