"""What `lfr verify` finds, in the episodes that it names: on the timeline, and as a list to read.

Entities, on the timelines of `lfr.view.episode`:

    /findings       TextLog       each finding at its first frame and at its last; at frame 0 where
                                  it is about none; level ERROR or WARN
    /findings/list  TextDocument  all of them, with the episode's score

A click on a time in the log leads there. Links of a document lead to entities alone (rerun 0.33).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lfr.data.episode import Episode
from lfr.errors import LfrError
from lfr.view.blueprint import FINDINGS, FINDINGS_LIST
from lfr.view.collection import EPISODE_ALONE, Overlay
from lfr.view.dataset import is_dataset
from lfr.view.motion import Poses
from lfr.view.selection import Entry
from lfr.view.series import fps_of, frame_times

if TYPE_CHECKING:
    import rerun as rr

    from lfr.curation.finding import Finding
    from lfr.curation.verify import Report

LEVELS = {"error": "ERROR", "warning": "WARN"}


@dataclass(frozen=True)
class Note:
    """A finding in an episode, and the frames there that it is about; None where about none."""

    finding: Finding
    frames: tuple[int, int] | None


@dataclass(frozen=True)
class Findings:
    """What is found of a dataset, by episode."""

    report: Report

    def marked(self, entries: Iterable[Entry]) -> list[Entry]:
        """The entries with their scores and the kinds of findings that name them.

        Raises:
            LfrError: the report is of another dataset.
        """
        entries = list(entries)
        scores = {score.episode: score for score in self.report.scores}
        frames = sum(entry.length for entry in entries), self.report.frames
        if len(entries) != len(scores) or frames[0] != frames[1]:
            raise LfrError(
                f"the findings are of another dataset, {self.report.path}: found "
                f"{len(scores)} episodes, {frames[1]} frames, expected {len(entries)}, {frames[0]}"
            )
        found = [(entry, scores.get(entry.index)) for entry in entries]
        return [
            entry if score is None else replace(entry, score=score.score, kinds=score.kinds)
            for entry, score in found
        ]

    def notes(self, episode: int) -> list[Note]:
        """The findings that name an episode."""
        return [
            Note(finding, self._frames(finding, episode))
            for finding in self.report.findings
            if episode in finding.episodes
        ]

    def _frames(self, finding: Finding, episode: int) -> tuple[int, int] | None:
        """Frames are of the episode that a finding names first, and so is its row."""
        if episode != finding.episode:
            return None
        if finding.frames is not None or finding.row is None:
            return finding.frames
        frame = finding.row - sum(self.report.lengths[:episode])
        inside = 0 <= frame < self.report.lengths[episode]
        return (frame, frame) if inside else None


def findings_of(path: Path, file: Path | None) -> Findings:
    """The findings of a dataset, out of what `lfr verify --json` printed, or looked for now.

    Raises:
        LfrError: no dataset, or a file that holds something else.
    """
    from lfr.curation.saved_report import read_report
    from lfr.curation.verify import verify_dataset

    if not is_dataset(path):
        raise LfrError(f"--findings are of a dataset: found {path}, expected a LeRobot dataset")
    return Findings(verify_dataset(path) if file is None else read_report(file))


def findings_overlay(findings: Findings, beside: Overlay = EPISODE_ALONE) -> Overlay:
    """What is shown of them with an episode, together with what else is shown beside it."""

    def log(recording: rr.RecordingStream, episode: Episode, poses: Poses) -> None:
        beside.log(recording, episode, poses)
        log_findings(recording, episode, findings)

    return Overlay(lambda layout: beside.blueprint(replace(layout, findings=True)), log)


def log_findings(recording: rr.RecordingStream, episode: Episode, findings: Findings) -> None:
    """Log the findings that name an episode of the dataset."""
    import rerun as rr

    number = int(episode.metadata["episode"])
    notes, score = findings.notes(number), findings.report.scores[number].score
    rows = sorted((row for note in notes for row in _rows(note)), key=lambda row: row[0])
    if rows:
        frames, levels, texts = zip(*rows, strict=True)
        recording.send_columns(
            FINDINGS,
            indexes=frame_times(np.array(frames), fps_of(episode)),
            columns=rr.TextLog.columns(text=texts, level=levels),
        )
    text = _document(number, score, notes, fps_of(episode))
    recording.log(FINDINGS_LIST, rr.TextDocument(text, media_type="text/markdown"), static=True)


def _rows(note: Note) -> list[tuple[int, str, str]]:
    """Frame, level and text of each line of the log."""
    from lfr.curation.report.words import places

    finding, (first, last) = note.finding, note.frames or (0, 0)
    level, check, shown = LEVELS[finding.severity], finding.check, places(finding)
    where = "" if note.frames is None else f"frame {first}: "
    words = [f"{name} {shown[name]}" for name in ("column", "found", "expected") if name in shown]
    text = f"{where}{check}: {': '.join([finding.message, *([', '.join(words)] if words else [])])}"
    if first == last:
        return [(first, level, text)]
    return [(first, level, text), (last, level, f"frame {last}: {check}: since frame {first}")]


def _document(episode: int, score: float, notes: Sequence[Note], fps: float) -> str:
    """The findings in Markdown, in which no word of the dataset is a link or a picture."""
    from lfr.curation.report.words import code, places

    lines = [f"# Episode {episode}: score {score:g}", ""]
    for note in notes:
        finding = note.finding
        lines.append(f"**{finding.severity}** {code(finding.check)} {code(finding.message)}")
        if note.frames is not None:
            first, last = note.frames
            when = f"{first / fps:.2f} s" + (f" to {last / fps:.2f} s" if last > first else "")
            lines.append(f"- at {when}")
        shown = {name: text for name, text in places(finding).items() if name != "episode"}
        lines += [f"- {name} {code(text)}" for name, text in shown.items()]
        lines.append("")
    return "\n".join(lines if notes else [*lines, "Nothing is found in it.", ""])
