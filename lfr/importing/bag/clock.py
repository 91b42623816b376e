"""Which of a message's times is its time: when it was measured, recorded or published.

A header's stamp is the better one: it says when a picture was taken or joints were read, while a
recorder's clock adds the way through the network, other for each topic. But stamps of two clocks
cannot be compared. So they are taken where every feature has them and they all keep the same
distance to the recorder's clock; else the recorder's, for all features.
"""

from __future__ import annotations

import numpy as np

from lfr.errors import DataError
from lfr.importing.bag.index import BagIndex
from lfr.importing.bag.mapping import BagMapping, Clock
from lfr.importing.bag.resample import SECOND, Times

APART = SECOND  # ns; two topics' stamps further apart than this are of two clocks
BACK = SECOND  # ns; what is earlier than its forerunner by more is no late message


def choose_clock(index: BagIndex, mapping: BagMapping) -> Clock:
    """The clock for all bags, told from the first; the reason is noted if it is not the headers'.

    Raises:
        DataError: the mapping wants the headers' and a topic has none.
    """
    if mapping.time is not None:
        check_clock(index, mapping, mapping.time)
        return mapping.time
    if why := _against_headers(index, mapping):
        index.notes.append(f"time is that of recording, not the header's: {why}")
        return "log"
    return "header"


def check_clock(index: BagIndex, mapping: BagMapping, clock: Clock) -> None:
    """Raises DataError when a bag's messages do not have the clock that was chosen."""
    if clock != "header":
        return
    for name in _topics(mapping):
        if lacking := _without(index, name):
            raise DataError("no stamp in the header; say `time: log` in the mapping",
                            file=index.bag.path, column=name,
                            found=f"{lacking} messages without")  # fmt: skip


def jumps_back(times: Times) -> tuple[int, int] | None:
    """From when to when a topic's clock is not to be trusted, since it goes back; ns.

    Messages that come a little late among others are none of this.
    """
    latest = np.maximum.accumulate(times)
    back = latest - times > BACK
    if not back.any():
        return None
    return int(times[back].min()), int(latest[back].max())


def _against_headers(index: BagIndex, mapping: BagMapping) -> str | None:
    offsets: dict[str, float] = {}
    for name in _topics(mapping):
        if lacking := _without(index, name):
            return f"{name} has {lacking} messages without a stamp"
        topic = index.topics[name]
        kept = np.delete(topic.times("header") - topic.times("log"), topic.lost)
        offsets[name] = float(np.median(kept))
    low, high = min(offsets, key=lambda n: offsets[n]), max(offsets, key=lambda n: offsets[n])
    if offsets[high] - offsets[low] > APART:
        apart = (offsets[high] - offsets[low]) / SECOND
        return f"the stamps of {high} and {low} are of two clocks, {apart:.1f} s apart"
    return None


def _topics(mapping: BagMapping) -> list[str]:
    return list(dict.fromkeys(part.topic for part in mapping.parts))


def _without(index: BagIndex, name: str) -> int:
    topic = index.topics[name]
    return int((np.delete(topic.times("header"), topic.lost) == 0).sum())
