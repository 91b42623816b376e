"""The first reading of a bag: when each message is, and which are of use; contents are left.

Per message it keeps 16 bytes, so that a bag's size does not matter.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mcap.records import Message
from numpy.typing import NDArray

from lfr.errors import DataError
from lfr.importing.bag.decoding import MessageError, stamp_in_cdr, stamp_of
from lfr.importing.bag.files import Bag
from lfr.importing.bag.mapping import BagMapping, Clock, Part, TaskTopic
from lfr.importing.bag.parts import PartReader
from lfr.importing.bag.pictures import check_kind
from lfr.importing.bag.reading import Source, read_messages
from lfr.importing.bag.values import value_at

LATEST = 2**62  # ns; what a clock gone wrong says later than this is as good as this


@dataclass
class Topic:
    """The messages of one topic, in the order of the file.

    Attributes:
        name, type: of the topic.
        log: when each was recorded, or published if the mapping asks for that, ns.
        header: its own stamp, ns; 0 where it has none.
        said: what each says, of topics that say the task or mark episodes.
        lost: those that cannot be decoded, by their places.
    """

    name: str
    type: str = ""
    log: array[int] = field(default_factory=lambda: array("q"))
    header: array[int] = field(default_factory=lambda: array("q"))
    said: list[Any] = field(default_factory=list)
    lost: list[int] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.log)

    def times(self, clock: Clock) -> NDArray[np.int64]:
        """When each message is, ns."""
        return np.array(self.header if clock == "header" else self.log, np.int64)


@dataclass
class BagIndex:
    """What the first reading finds.

    Attributes:
        bag: of which.
        topics: by name, those that the mapping names.
        ours: of a part whose topic others publish on too, whether each message is the part's.
        first: when the bag's first message was recorded, ns; the zero of the times in messages.
        notes: what the reader of the report is to know.
    """

    bag: Bag
    topics: dict[str, Topic]
    ours: dict[Part, bytearray]
    first: int = LATEST
    notes: list[str] = field(default_factory=list)

    def places(self, part: Part) -> NDArray[np.int64]:
        """The numbers, on their topic, of the messages that are a part's."""
        topic = self.topics[part.topic]
        ours = np.ones(len(topic), bool)
        if part in self.ours:
            ours = np.frombuffer(self.ours[part], np.bool_).copy()
        ours[topic.lost] = False
        return np.flatnonzero(ours)

    def forget_times(self) -> None:
        """Give back the memory of what only planning needs."""
        self.topics, self.ours = {}, {}

    def at(self, time: int) -> str:
        """A time in the bag, for messages."""
        return f"{(time - self.first) / 1e9:.3f} s"


def index_bag(bag: Bag, mapping: BagMapping, readers: Mapping[Part, PartReader]) -> BagIndex:
    """Read a bag for the first time.

    Args:
        readers: of the parts that are numbers; they learn their names from the first bag.

    Raises:
        DataError: a topic, field or joint is missing; the message lists those there are. Or
            messages that cannot be decoded, or a file that cannot be read.
    """
    return _Indexing(bag, mapping, readers).run()


def readers_of(mapping: BagMapping) -> dict[Part, PartReader]:
    """A reader for each part that is numbers."""
    return {part: PartReader(part) for parts in mapping.numbers.values() for part in parts}


class _Indexing:
    def __init__(self, bag: Bag, mapping: BagMapping, readers: Mapping[Part, PartReader]) -> None:
        self._bag, self._mapping, self._readers = bag, mapping, readers
        sayers = {mapping.episodes.topic: mapping.episodes.field}
        if isinstance(mapping.task, TaskTopic):
            if sayers.get(mapping.task.topic, mapping.task.field) != mapping.task.field:
                raise DataError("one topic for task and episodes by two fields", file=bag.path)
            sayers[mapping.task.topic] = mapping.task.field
        self._sayers = {topic: path for topic, path in sayers.items() if topic is not None}
        self._parts: dict[str, list[Part]] = {}
        for part in mapping.parts:
            self._parts.setdefault(part.topic, []).append(part)
        names = [*self._parts, *self._sayers]
        self._index = BagIndex(bag, {name: Topic(name) for name in names}, {})
        self._others: dict[str, str] = {}  # topics that are not asked for, and their types

    def run(self) -> BagIndex:
        index, topics = self._index, self._index.topics
        for source, message in read_messages(self._bag, None, index.notes):
            index.first = min(index.first, message.log_time)
            if (topic := topics.get(source.topic)) is None:
                self._others[source.topic] = source.type
                continue
            if not len(topic):
                self._meet(topic, source, message)
            self._add(topic, source, message)
        self._check()
        return index

    def _meet(self, topic: Topic, source: Source, message: Message) -> None:
        """The first message of a topic, which has to be what the mapping says."""
        topic.type = source.type or source.encoding
        try:
            decoded = source.decode(message.data)
            for part in self._parts.get(topic.name, ()):
                if (reader := self._readers.get(part)) is None:
                    check_kind(decoded)
                elif reader.names is None:
                    reader.learn(decoded)
                elif not reader.joints:
                    reader.read(decoded)
            if topic.name in self._sayers:
                value_at(decoded, self._sayers[topic.name])
        except MessageError as error:
            at = self._index.at(message.log_time)
            raise DataError(f"{error}", file=self._bag.path,
                            column=f"{topic.name} ({topic.type}), at {at}") from None  # fmt: skip

    def _add(self, topic: Topic, source: Source, message: Message) -> None:
        publish = self._mapping.time == "publish"
        place = len(topic)
        topic.log.append(min(message.publish_time if publish else message.log_time, LATEST))
        try:
            self._look(topic, place, source, message)
        except MessageError as error:
            if not topic.lost:
                since = self._index.at(topic.log[-1])
                self._index.notes.append(f"{topic.name}: messages that do not decode are left out, "
                                         f"the first at {since}: {error}")  # fmt: skip
            topic.lost.append(place)
        topic.header.extend([0] * (len(topic) - len(topic.header)))

    def _look(self, topic: Topic, place: int, source: Source, message: Message) -> None:
        readers = [self._readers.get(part) for part in self._parts.get(topic.name, ())]
        joints = [reader for reader in readers if reader is not None and reader.joints]
        headers = self._mapping.time in (None, "header")
        decoded = None
        if joints or topic.name in self._sayers or (headers and not source.header_first):
            decoded = source.decode(message.data)
        if headers:
            own = stamp_of(decoded) if decoded is not None else stamp_in_cdr(message.data)
            topic.header.append(max(0, min(own or 0, LATEST)))
        if topic.name in self._sayers:
            topic.said.extend([None] * (place - len(topic.said)))
            topic.said.append(value_at(decoded, self._sayers[topic.name]))
        for reader in joints:
            ours = self._index.ours.setdefault(reader.part, bytearray())
            ours.extend(bytes(place - len(ours)))
            ours.append(not reader.is_others(decoded))

    def _check(self) -> None:
        there = {**{t.name: t.type for t in self._index.topics.values() if len(t)}, **self._others}
        if not there:
            raise DataError("no messages", file=self._bag.path)
        for name, topic in self._index.topics.items():
            if not len(topic):
                listed = ", ".join(f"{name} ({type})" for name, type in sorted(there.items()))
                raise DataError("no messages on this topic", file=self._bag.path, column=name,
                                found=listed, expected=name)  # fmt: skip
        for part, ours in self._index.ours.items():
            ours.extend(bytes(len(self._index.topics[part.topic]) - len(ours)))
        for part, reader in self._readers.items():
            names, apart = reader.missing()
            if apart:
                found = "; ".join(f"[{', '.join(names)}]" for names in reader.met)
                raise DataError("joints that no message has together; make a part for each of",
                                file=self._bag.path, column=part.topic, found=found)  # fmt: skip
            if names:
                raise DataError(f"no joint {', '.join(names)}", file=self._bag.path,
                                column=f"{part.topic}, {part.field}",
                                found=", ".join(sorted({n for met in reader.met for n in met})),
                                expected=", ".join(reader.names or ()))  # fmt: skip
