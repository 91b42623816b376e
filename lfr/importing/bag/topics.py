"""What a bag holds, topic by topic, for someone who has not seen it before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from lfr.importing.bag.decoding import MessageError, fields, stamp_of
from lfr.importing.bag.files import Bag
from lfr.importing.bag.pictures import check_kind, is_picture, picture
from lfr.importing.bag.reading import read_messages
from lfr.importing.bag.values import number_paths, numbers

LOOKED_AT = 20  # messages of each topic that are decoded
Names = tuple[str, ...]


@dataclass
class TopicSummary:
    """One topic.

    Attributes:
        name, type: of the topic; type is the encoding where there is no schema.
        messages: how many.
        first, last: when they were recorded, ns.
        numbers: what can be part of a feature: path -> the names of its numbers, or how many there
            are without names. A path that publishers give different names has an entry for each.
        pictures: width and height.
        text: its messages are one text, or one bool, `data`.
        header: its messages have stamps of their own.
        unread: why it cannot be a feature.
    """

    name: str
    type: str
    messages: int = 0
    first: int = 2**64
    last: int = 0
    numbers: dict[str, list[Names | int]] = field(default_factory=dict)
    pictures: tuple[int, int] | None = None
    text: bool = False
    header: bool = False
    unread: str = ""

    @property
    def rate(self) -> float:
        """Messages per second, in the mean; 0 of one message."""
        seconds = (self.last - self.first) / 1e9
        return (self.messages - 1) / seconds if seconds > 0 else 0.0

    def look(self, message: Any) -> None:
        """Learn from a message.

        Raises:
            MessageError: a picture that is not supported.
        """
        self.header = stamp_of(message) is not None
        if is_picture(self.type) or {"encoding", "step"} <= set(fields(message)):
            check_kind(message)
            self.pictures = picture(message).size
            return
        if fields(message) == ("data",):
            self.text = isinstance(getattr(message, "data", None), str)
        for path in number_paths(message):
            names, values = numbers(message, path)
            listed = self.numbers.setdefault(path, [])
            found = names or len(values)
            if not any(_same(found, other) for other in listed):
                listed.append(found)


def summarise(bag: Bag, notes: list[str]) -> list[TopicSummary]:
    """The topics of a bag, by name.

    Args:
        notes: is given a line for each file that was cut off.

    Raises:
        DataError: a file that cannot be read.
    """
    topics: dict[str, TopicSummary] = {}
    for source, message in read_messages(bag, None, notes):
        topic = topics.get(source.topic)
        if topic is None:
            topic = TopicSummary(source.topic, source.type or source.encoding)
            topics[source.topic] = topic
        topic.messages += 1
        topic.first = min(topic.first, message.log_time)
        topic.last = max(topic.last, message.log_time)
        if topic.messages <= LOOKED_AT and not (topic.pictures or topic.unread):
            try:
                topic.look(source.decode(message.data))
            except MessageError as error:
                topic.unread = str(error)
    return sorted(topics.values(), key=lambda topic: topic.name)


def kinds(topic: TopicSummary) -> Iterator[tuple[str, Names | int]]:
    """Each set of numbers of a topic, and its path."""
    for path, listed in topic.numbers.items():
        yield from ((path, found) for found in listed)


def _same(one: Names | int, other: Names | int) -> bool:
    """Names in another order are the same joints."""
    if isinstance(one, int) or isinstance(other, int):
        return one == other
    return set(one) == set(other)
