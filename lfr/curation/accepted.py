"""Findings that are known and accepted, as a file lists them: set aside, so that new ones show.

The file holds what `lfr verify --json` printed, or a list in YAML or JSON of entries such as
`{check: constant, column: "action[6]"}`.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lfr.curation.finding import Finding
from lfr.curation.kinds import KINDS
from lfr.curation.verify import Report
from lfr.errors import DataError, UnknownNameError

KEYS = ("check", "episode", "column", "file")
NAMED = 10  # entries, in the line of those that match nothing

Key = tuple[str, str | None, str | None]
"""Check, column and file; None is any."""


@dataclass(frozen=True)
class Entry:
    """What is accepted; None is any.

    Attributes:
        check: a kind.
        column, file: as a finding names them, "" where it names none.
        episodes: that may be named; a finding that names one more is not accepted. None of them
            is a finding about the whole dataset.
    """

    check: str
    column: str | None = None
    file: str | None = None
    episodes: frozenset[int] | None = None

    def __str__(self) -> str:
        episodes = ", ".join(map(str, sorted(self.episodes or ())))
        named = {"episode": episodes, "column": self.column, "file": self.file}
        return ", ".join([self.check, *(f"{name} {text}" for name, text in named.items() if text)])

    @property
    def key(self) -> Key:
        return self.check, self.column, self.file


def read_accepted(file: Path) -> list[Entry]:
    """The entries of a file.

    Raises:
        DataError: no such file, or not what it should hold.
        UnknownNameError: a key or a kind that there is not.
    """
    content = _content(file)
    if isinstance(content, dict) and "findings" in content:
        every = [*_list(file, content["findings"]), *_list(file, content.get("accepted") or [])]
        return [_of_finding(Finding.from_json(each, file)) for each in every]
    return [_entry(file, number, each) for number, each in enumerate(_list(file, content or []))]


def accept(report: Report, entries: Iterable[Entry], file: Path) -> Report:
    """The report with what the entries accept set aside, and those that match nothing named."""
    entries = list(entries)
    known: dict[Key, list[Entry]] = defaultdict(list)
    for entry in entries:
        known[entry.key].append(entry)
    anywhere = {key for key, those in known.items() if any(e.episodes is None for e in those)}
    whole = {key for key, those in known.items() if frozenset() in {e.episodes for e in those}}
    listed = {key: frozenset().union(*(e.episodes or () for e in those))
              for key, those in known.items()}  # fmt: skip
    seen: dict[Key, set[int | None]] = defaultdict(set)
    kept, accepted = [], []
    for finding in report.findings:
        keys = [key for key in _keys(finding) if key in known]
        for key in keys:
            seen[key].update(finding.episodes or {None})
        covered = frozenset().union(*(listed[key] for key in keys))
        named = not finding.episodes and any(key in whole for key in keys)
        if named or any(key in anywhere for key in keys) or (
            finding.episodes and covered.issuperset(finding.episodes)
        ):  # fmt: skip
            accepted.append(finding)
        else:
            kept.append(finding)
    unmatched = [str(entry) for entry in entries if not _matched(entry, seen)]
    return replace(
        report, findings=tuple(kept), accepted=tuple(accepted), unmatched=_line(file, unmatched)
    )


def _matched(entry: Entry, seen: Mapping[Key, set[int | None]]) -> bool:
    there = seen.get(entry.key, set())
    return bool(there if entry.episodes is None else there & (entry.episodes or {None}))


def _line(file: Path, entries: list[str]) -> str:
    if not entries:
        return ""
    more = f"; and {len(entries) - NAMED} more" if len(entries) > NAMED else ""
    return f"{file}: nothing matches any more: {'; '.join(entries[:NAMED])}{more}"


def _keys(finding: Finding) -> Iterator[Key]:
    for column in (finding.column or "", None):
        for file in (finding.file, None):
            yield finding.check, column, file


def _of_finding(finding: Finding) -> Entry:
    return Entry(finding.check, finding.column or "", finding.file, frozenset(finding.episodes))


def _entry(file: Path, number: int, entry: Any) -> Entry:
    where = f"entry {number + 1}"
    if not isinstance(entry, dict):
        raise DataError(f"{where} is no mapping", file=file, found=type(entry).__name__,
                        expected="such as {check: constant, column: action}")  # fmt: skip
    for key in entry:
        if key not in KEYS:
            raise UnknownNameError(f"key in {where} of {file}:", str(key), KEYS)
    if "check" not in entry:
        raise DataError(f"{where} has no check", file=file, expected="the kind of a finding")
    for key in ("check", "column", "file"):
        if key in entry and not isinstance(entry[key], str):
            raise DataError(
                f"{where}: {key} is no text", file=file, found=type(entry[key]).__name__
            )
    if entry["check"] not in KINDS:
        raise UnknownNameError(f"kind in {where} of {file}:", entry["check"], KINDS)
    return Entry(
        entry["check"], entry.get("column"), entry.get("file"), _episodes(file, where, entry)
    )


def _episodes(file: Path, where: str, entry: Mapping[str, Any]) -> frozenset[int] | None:
    if "episode" not in entry:
        return None
    named = entry["episode"]
    episodes = named if isinstance(named, list) else [named]
    if not episodes or not all(type(episode) is int for episode in episodes):
        raise DataError(f"{where}: episode is no whole number, nor a list of them", file=file,
                        found=type(named).__name__)  # fmt: skip
    return frozenset(episodes)


def _list(file: Path, content: Any) -> list[Any]:
    if not isinstance(content, list):
        raise DataError("no accepted findings", file=file, found=type(content).__name__,
                        expected="a list, or what lfr verify --json prints")  # fmt: skip
    return content


def _content(file: Path) -> Any:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        text = file.read_text(encoding="utf-8")
        try:
            return json.loads(text)
        except ValueError:
            return YAML(typ="safe").load(text)
    except FileNotFoundError:
        raise DataError("the file is missing", file=file) from None
    except (OSError, ValueError, RecursionError, YAMLError) as error:
        raise DataError("cannot be read", file=file, found=_short(error)) from None


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:200]
