"""The plan of a bag's episodes: which message is taken for which frame, and what is refused."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfr.importing.bag.clock import jumps_back
from lfr.importing.bag.index import BagIndex
from lfr.importing.bag.mapping import BagMapping, Clock, Part
from lfr.importing.bag.resample import SECOND, Times, frame_times, frames_between, missing, pick
from lfr.importing.bag.spans import Span, find_spans, task_in

MOST_FRAMES = 10**7  # of an episode
LEAST_FRAMES = 2
TRIMMED = SECOND  # ns; that much of a span without one of its topics is told
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Planned:
    """An episode: from when, and how many frames. `steps` also counts the frame after the last,
    where a feature is the next one's."""

    start: int
    frames: int
    steps: int
    task: str


@dataclass
class BagPlan:
    """What of a bag becomes frames.

    Attributes:
        index: of the bag.
        episodes: in order of time.
        picks: of each part and each step of all episodes, the place of its message on its topic.
        lags: of each part and frame, the time from its message to the frame, ns.
        refused: why a time is no episode, a line for each.
        notes: what else is to be known.
    """

    index: BagIndex
    episodes: list[Planned] = field(default_factory=list)
    picks: dict[Part, Ints] = field(default_factory=dict)
    lags: dict[Part, Ints] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def without(self, wrong: set[int]) -> BagPlan:
        """The plan without these episodes."""
        kept = np.array([i not in wrong for i in range(len(self.episodes))], bool)
        steps = np.repeat(kept, [e.steps for e in self.episodes])
        frames = np.repeat(kept, [e.frames for e in self.episodes])
        return BagPlan(
            self.index,
            [e for e, keep in zip(self.episodes, kept, strict=True) if keep],
            {part: places[steps] for part, places in self.picks.items()},
            {part: lags[frames] for part, lags in self.lags.items()},
            self.refused,
            self.notes,
        )


@dataclass(frozen=True, eq=False)
class _Stream:
    """A part's messages in the order of time: when each is, and its place on the topic."""

    part: Part
    stamps: Times
    places: Ints
    tolerance: float  # ns
    back: tuple[int, int] | None  # where its clock goes back

    @classmethod
    def of(cls, index: BagIndex, mapping: BagMapping, clock: Clock, part: Part) -> _Stream:
        places = index.places(part)
        times = index.topics[part.topic].times(clock)[places]
        order = np.argsort(times, kind="stable")
        back = jumps_back(times) if len(times) else None
        return cls(part, times[order], places[order], mapping.tolerance_of(part), back)

    @property
    def always(self) -> bool:
        """It speaks all the time, not only when something changes."""
        return bool(np.isfinite(self.tolerance))

    def first(self, start: int) -> int | None:
        """When the first of its messages is that can serve a span."""
        at = int(np.searchsorted(self.stamps, start - self.tolerance)) if self.always else 0
        return int(self.stamps[at]) if at < len(self.stamps) else None

    def last(self, end: int) -> int:
        if not self.always:
            return end
        at = int(np.searchsorted(self.stamps, end, side="right"))
        return int(self.stamps[max(at - 1, 0)])


def plan_bag(index: BagIndex, mapping: BagMapping, clock: Clock) -> BagPlan:
    """Find the episodes of a bag and the messages of their frames."""
    plan = BagPlan(index)
    streams = [_Stream.of(index, mapping, clock, part) for part in mapping.parts]
    picks: dict[Part, list[Ints]] = {stream.part: [] for stream in streams}
    lags: dict[Part, list[Ints]] = {stream.part: [] for stream in streams}
    if silent := [s.part.topic for s in streams if not len(s.stamps)]:
        plan.refused.append(f"{index.bag}: refused: no messages of {', '.join(silent)} with what "
                            "the mapping asks for")  # fmt: skip
        spans = []
    else:
        always = [s.stamps for s in streams if s.always] or [s.stamps for s in streams]
        spans = find_spans(index, mapping, clock, always)
        if not spans:
            plan.refused.append(f"{index.bag}: no episode: nothing on {mapping.episodes.topic} "
                                f"says {mapping.episodes.start!r}")  # fmt: skip
    for span in spans:
        for episode in _episodes(plan, mapping, clock, streams, span):
            times = frame_times(episode.start, mapping.fps, episode.steps)
            for stream in streams:
                found = pick(stream.stamps, times, stream.part.method)
                picks[stream.part].append(stream.places[found])
                used = np.abs(times - stream.stamps[found])[: episode.frames]
                lags[stream.part].append(used)
            plan.episodes.append(episode)
    none = np.zeros(0, np.int64)
    plan.picks = {part: np.concatenate([none, *found]) for part, found in picks.items()}
    plan.lags = {part: np.concatenate([none, *found]) for part, found in lags.items()}
    return plan


def _episodes(
    plan: BagPlan, mapping: BagMapping, clock: Clock, streams: list[_Stream], span: Span
) -> list[Planned]:
    """The episodes in a span: one, more where it is cut, or none, which is noted."""
    at = plan.index.at

    def refuse(why: str, start: int = span.start, end: int = span.end) -> list[Planned]:
        plan.refused.append(f"{plan.index.bag}, {at(start)} to {at(end)}: refused: {why}")
        return []

    if span.refused:
        return refuse(span.refused)
    for stream in streams:
        if stream.back and stream.back[0] <= span.end and stream.back[1] >= span.start:
            return refuse(f"the clock of {stream.part.topic} goes back between "
                          f"{at(stream.back[0])} and {at(stream.back[1])}")  # fmt: skip
    firsts = {stream.part.topic: stream.first(span.start) for stream in streams}
    silent = [t for t, first in firsts.items() if first is None or first > span.end]
    if silent:
        return refuse(f"no message of {', '.join(silent)}")
    late, begin = max(((t, f) for t, f in firsts.items() if f is not None), key=lambda tf: tf[1])
    start = max(span.start, begin)
    early, end = min(((s.part.topic, s.last(span.end)) for s in streams), key=lambda te: te[1])
    if start - span.start > TRIMMED:
        plan.notes.append(f"{plan.index.bag}: an episode begins at {at(start)}, not "
                          f"{at(span.start)}: {late} speaks only then")  # fmt: skip
    if span.end - end > TRIMMED:
        plan.notes.append(f"{plan.index.bag}: an episode ends at {at(end)}, not "
                          f"{at(span.end)}: {early} does not speak any longer")  # fmt: skip
    steps = frames_between(start, end, mapping.fps) if end >= start else 0
    further = 1 if mapping.nexts else 0
    if steps > MOST_FRAMES:
        return refuse(f"{steps} frames; has a clock jumped? `episodes: {{gap: 1.0}}` parts there")
    if steps < LEAST_FRAMES + further:
        return refuse(f"{max(steps - further, 0)} frames of it have messages on all topics")
    runs = {s: missing(s.stamps, start, mapping.fps, steps, s.part.method, s.tolerance)
            for s in streams}  # fmt: skip
    pieces = [(0, steps)]
    if any(len(found) for found in runs.values()):
        why = _why(plan.index, mapping, runs, start)
        if mapping.episodes.late == "refuse":
            return refuse(why, start, end)
        pieces = _pieces(np.concatenate(list(runs.values())), steps)
        pieces = [(a, b) for a, b in pieces if b - a >= LEAST_FRAMES + further]
        kept = sum(beyond - first for first, beyond in pieces)
        plan.notes.append(f"{plan.index.bag}, {at(start)} to {at(end)}: cut into {len(pieces)} "
                          f"episodes, {kept} of {steps} frames: {why}")  # fmt: skip
    episodes = []
    for first, beyond in pieces:
        begin = start + first * SECOND // mapping.fps
        until = start + (beyond - 1) * SECOND // mapping.fps
        task = task_in(plan.index, mapping, clock, begin, until)
        if not task:
            return refuse("no instruction up to its end", begin, until)
        episodes.append(Planned(begin, beyond - first - further, beyond - first, task))
    return episodes


def _why(index: BagIndex, mapping: BagMapping, runs: dict[_Stream, Ints], start: int) -> str:
    """Which topic has no message at what time, the longest time of each topic."""
    lines = []
    for stream, found in runs.items():
        if len(found):
            lengths = found[:, 1] - found[:, 0] + 1
            longest = found[int(lengths.argmax())]
            time = index.at(start + int(longest[0]) * SECOND // mapping.fps)
            seconds = int(lengths.max()) / mapping.fps
            more = f", and at {len(found) - 1} other times" if len(found) > 1 else ""
            lines.append(f"{stream.part.topic} has no message within {stream.tolerance / 1e9:.3g} "
                         f"s of {int(lengths.sum())} frames, at {time} for {seconds:.3g} s{more}"
                         f"{_slow(stream, mapping)}")  # fmt: skip
    return "; ".join(lines)


def _slow(stream: _Stream, mapping: BagMapping) -> str:
    """What to do about a topic that is usually too slow, not only once."""
    usual = float(np.median(np.diff(stream.stamps))) if len(stream.stamps) > 1 else 0.0
    reach = stream.tolerance * (2 if stream.part.method == "nearest" else 1)
    if usual <= reach:
        return ""
    return (f" (it speaks every {usual / 1e9:.3g} s; a larger tolerance, or a lower fps than "
            f"{mapping.fps}, allows that)")  # fmt: skip


def _pieces(runs: Ints, steps: int) -> list[tuple[int, int]]:
    """What is left between runs of frames, each (first, beyond the last)."""
    pieces, at = [], 0
    for first, last in runs[np.argsort(runs[:, 0], kind="stable")].tolist():
        if first > at:
            pieces.append((at, first))
        at = max(at, last + 1)
    return [*pieces, (at, steps)] if at < steps else pieces
