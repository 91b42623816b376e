"""What a checker says of a dataset, as a set of lines that two runs can be compared by.

The same rules for every checker. A finding is any part of its JSON report that has a severity or a
status and there a word of `BAD`; its line is its rule, its episode and its words, without numbers
other than episodes, since a measure that comes out a little different is no other finding. One of
several episodes is a line for each. A checker that prints no report but ends with an error has said
the last line of it. A traceback, a signal or running out of time is a crash, whatever was said.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

BAD = frozenset({
    "warn", "warning", "fail", "failed", "failure", "error", "errored", "critical", "high",
    "medium", "low", "hard_fail", "exclude", "excluded", "bad", "poor", "blocked", "review",
    "flag", "hard",
})  # fmt: skip
LEVEL = ("severity", "status", "level", "verdict", "quality")
RULE = ("check_id", "rule_id", "detector_id", "metric_id", "check", "gate", "code", "id", "name")
WORDS = ("message", "summary", "title", "reason", "column", "feature", "file", "reasons",
         "hard_flags")  # fmt: skip
EPISODE = ("episode", "episode_index", "episode_id", "episodes", "affected_episodes")
NUMBER = re.compile(
    r"(?<![a-z_\d.\[])[-+]?\d+([.,]\d+)*(e[-+]?\d+)?%?", re.IGNORECASE
)  # not joint_3
AN_EPISODE = re.compile(r"episodes?[ _#]*:?\s*\[?0*(\d+)", re.IGNORECASE)


@dataclass(frozen=True)
class Said:
    """What came of one run of a checker.

    Attributes:
        lines: its findings.
        crash: how it ended, where that is no way to end; else "".
    """

    lines: frozenset[str]
    crash: str = ""


def said(code: int | None, output: str, errors: str, report: Path | None, dataset: Path) -> Said:
    """What a run has said.

    Args:
        code: its exit code; None where it ran out of time.
        report: where it was to write its JSON report; None where it prints that.
        dataset: the folder it was given, which is left out of what it says.
    """
    if code is None:
        return Said(frozenset(), "no end in time")
    text = report.read_text("utf-8") if report is not None and report.is_file() else output
    content = _json(text) if report is None or report.is_file() else None
    if content is not None:
        lines = _findings(content, "", "")
    elif code == 0:
        lines = iter(())
    else:
        if code < 0 or "Traceback (most recent call last)" in output + errors:
            last = (errors or output).strip().splitlines() or [f"signal {-code}"]
            return Said(frozenset(), _plain(last[-1].strip(), dataset)[:160])
        told = [line for line in (output + "\n" + errors).splitlines() if line.strip()]
        lines = iter(told[-1:])
    return Said(frozenset(_plain(line, dataset) for line in lines if line.strip()))


def _json(text: str) -> Any:
    begin = min((at for at in (text.find("{"), text.find("[")) if at >= 0), default=-1)
    if begin < 0:
        return None
    try:
        return json.JSONDecoder().raw_decode(text[begin:])[0]
    except ValueError:
        return None


def _findings(part: Any, place: str, episode: str) -> Iterator[str]:
    """Lines of a part of a report, which stands at ``place`` and is about ``episode``."""
    if isinstance(part, list):
        for item in part:
            yield from _findings(item, place, episode)
    if not isinstance(part, dict):
        return
    episodes = _episodes(part)
    if any(str(part.get(key)).lower() in BAD for key in LEVEL):
        rule = [str(part[key]) for key in RULE if isinstance(part.get(key), str)][:1]
        found = (part.get(key) for key in WORDS)
        several = (one if isinstance(one, list) else [one] for one in found)
        words = [word for many in several for word in many if isinstance(word, str)]
        named = sorted({number for word in words for number in AN_EPISODE.findall(word)})
        for one in episodes or named or [episode]:
            line = " ".join([*(rule or [place]), *(_without_numbers(word) for word in words)])
            yield f"{line} [{one}]" if one else line
    for key, item in part.items():
        within = place if key.isdigit() else f"{place}/{key}"
        yield from _findings(item, within, episodes[0] if len(episodes) == 1 else episode)


def _episodes(part: dict[str, Any]) -> list[str]:
    """Which episodes a part of a report says that it is about."""
    locus = part.get("locus")
    for holder in (part, locus if isinstance(locus, dict) else {}):
        for key in EPISODE:
            found = holder.get(key)
            if key.endswith("episodes") != isinstance(found, list):  # that is how many there are
                continue
            many = found if isinstance(found, list) else [found]
            if many and all(isinstance(one, int | str) for one in many):
                return [re.sub(r".*?0*(\d+)$", r"\1", str(one)) for one in many]
    return []


def _without_numbers(text: str) -> str:
    return NUMBER.sub("#", AN_EPISODE.sub("episode #", " ".join(text.split())))


def _plain(line: str, dataset: Path) -> str:
    for name in (str(dataset), dataset.name):
        line = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", "DATASET", line)
    return re.sub(r"\x1b\[[0-9;]*m", "", line)[:400]
