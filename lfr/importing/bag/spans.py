"""Where the episodes of a bag are: the whole bag, between pauses, or as a topic says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lfr.importing.bag.index import BagIndex
from lfr.importing.bag.mapping import BagMapping, Clock, TaskTopic
from lfr.importing.bag.resample import SECOND, Times

Said = list[tuple[int, Any]]


@dataclass(frozen=True)
class Span:
    """A time in which there may be an episode, ns, both ends included.

    `refused` says why it cannot be one.
    """

    start: int
    end: int
    refused: str = ""


def find_spans(
    index: BagIndex, mapping: BagMapping, clock: Clock, stamps: Sequence[Times]
) -> list[Span]:
    """The spans of a bag, in order of time.

    Args:
        stamps: of each part's messages, which rise; of those that speak all the time.
    """
    rule = mapping.episodes
    if rule.topic is not None:
        said = said_on(index, rule.topic, clock)
        last = max(int(times[-1]) for times in stamps)
        return _marked(said, rule.start, rule.end, last)
    start, end = min(int(t[0]) for t in stamps), max(int(t[-1]) for t in stamps)
    if rule.gap is None:
        return [Span(start, end)]
    every = np.sort(np.concatenate(list(stamps)))
    pauses = np.flatnonzero(np.diff(every) > rule.gap * SECOND)
    starts, ends = [start, *every[pauses + 1].tolist()], [*every[pauses].tolist(), end]
    return [Span(a, b) for a, b in zip(starts, ends, strict=True)]


def said_on(index: BagIndex, name: str, clock: Clock) -> Said:
    """What a topic says and when, in order of time; by its own stamps where it has them."""
    topic = index.topics[name]
    headers = clock == "header" and not topic.lost and all(topic.header)
    times = topic.times("header" if headers else "log").tolist()
    pairs = zip(times, topic.said, strict=False)
    return sorted(((t, v) for t, v in pairs if v is not None), key=lambda pair: pair[0])


def task_in(index: BagIndex, mapping: BagMapping, clock: Clock, start: int, end: int) -> str:
    """The instruction of an episode, "" where none was said."""
    if not isinstance(mapping.task, TaskTopic):
        return mapping.task.strip()
    said = [(t, str(v).strip()) for t, v in said_on(index, mapping.task.topic, clock)]
    before = [words for time, words in said if time <= start and words]
    within = [words for time, words in said if start < time <= end and words]
    return before[-1] if before else within[0] if within else ""


def _marked(said: Said, start: Any, end: Any, last: int) -> list[Span]:
    """A value that is said again and again, without another between, is one."""
    spans: list[Span] = []
    begun: int | None = None
    before: Any = None
    for time, value in said:
        if value == start and (end is None or value != before):
            if begun is not None:
                again = "" if end is None else f"it begins again before {end!r} ends it"
                spans.append(Span(begun, time - 1, again))
            begun = time
        elif end is not None and value == end and begun is not None:
            spans.append(Span(begun, time))
            begun = None
        before = value
    if begun is not None and last > begun:
        spans.append(Span(begun, last, "" if end is None else f"the bag ends before {end!r}"))
    return spans
