"""The second reading of a bag: the messages that frames want, numbers kept, pictures encoded.

A picture goes on to its video as soon as those before it are there, so none is held for longer
than the messages of its topic are out of order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfr.data.stats import Stats
from lfr.errors import DataError
from lfr.importing.bag.decoding import MessageError
from lfr.importing.bag.episodes import BagPlan
from lfr.importing.bag.mapping import Part
from lfr.importing.bag.parts import PartReader
from lfr.importing.bag.pictures import picture
from lfr.importing.bag.reading import Source, read_messages

if TYPE_CHECKING:
    from lfr.data.video import VideoWriter

MOST_HELD = 256 * 2**20  # bytes of a camera's pictures that wait for earlier ones
Ints = NDArray[np.int64]
Size = tuple[int, int]


@dataclass
class Filled:
    """What the second reading finds.

    Attributes:
        values: of each part that is numbers, (steps of all episodes, D) float64.
        videos: of each camera's episodes, where they are and the statistics of their pixels.
        wrong: episode -> why it cannot be one.
        sizes: camera -> episode -> width and height of its pictures.
    """

    values: dict[Part, NDArray[np.float64]]
    videos: dict[str, list[tuple[dict[str, Any], Stats]]] = field(default_factory=dict)
    wrong: dict[int, str] = field(default_factory=dict)
    sizes: dict[str, dict[int, Size]] = field(default_factory=dict)


def fill(
    plan: BagPlan, readers: Mapping[Part, PartReader], cameras: Mapping[str, Part],
    videos: Mapping[str, VideoWriter] | None,
) -> Filled:  # fmt: skip
    """Read a bag for the second time.

    Once a message is wrong no more is encoded, since the videos have to be made again; all further
    wrong ones are found all the same.

    Args:
        plan: of a bag with episodes.
        videos: of each camera, open; left as they are after the bag's last episode. None only
            looks for what is wrong.

    Raises:
        DataError: pictures too far out of order, or a file that cannot be read.
    """
    steps = np.array([e.steps for e in plan.episodes], np.int64)
    filled = Filled({part: np.full((int(steps.sum()), len(reader.dimensions)), np.nan)
                     for part, reader in readers.items()})  # fmt: skip
    episode_of = np.repeat(np.arange(len(steps)), steps)
    takers: dict[str, list[_Numbers | _Pictures]] = {}
    for part, reader in readers.items():
        taker = _Numbers(plan.picks[part], reader, filled, episode_of)
        takers.setdefault(part.topic, []).append(taker)
    frames = np.concatenate([np.zeros(0, bool), *(np.arange(e.steps) < e.frames
                                                  for e in plan.episodes)])  # fmt: skip
    for key, part in cameras.items():
        video = None if videos is None else videos[key]
        taker = _Pictures(plan, key, plan.picks[part][frames], video, filled, episode_of[frames])
        takers.setdefault(part.topic, []).append(taker)
    places = dict.fromkeys(takers, 0)
    for source, message in read_messages(plan.index.bag, takers.keys()):
        place = places[source.topic]
        places[source.topic] += 1
        at = plan.index.at(message.log_time)
        for taker in takers[source.topic]:
            taker.take(place, source, message.data, at)
    for listed in takers.values():
        for taker in listed:
            taker.finish()
    return filled


class _Wanted:
    """Which messages of a topic are wanted, and for which rows; messages come by their place."""

    def __init__(self, picks: Ints) -> None:
        self._rows = np.argsort(picks, kind="stable")
        self._places, starts = np.unique(picks[self._rows], return_index=True)
        self._bounds = np.append(starts, len(picks))
        self._next = 0

    def rows(self, place: int) -> Ints | None:
        at = self._next
        if at == len(self._places) or self._places[at] != place:
            return None
        self._next += 1
        return self._rows[self._bounds[at] : self._bounds[at + 1]]


class _Numbers:
    """Puts one part's numbers into the rows that want them."""

    def __init__(self, picks: Ints, reader: PartReader, filled: Filled, episode_of: Ints) -> None:
        self._wanted, self._reader, self._filled = _Wanted(picks), reader, filled
        self._values, self._episode_of = filled.values[reader.part], episode_of

    def take(self, place: int, source: Source, data: bytes, at: str) -> None:
        if (rows := self._wanted.rows(place)) is None:
            return
        try:
            numbers = self._reader.read(source.decode(data))
            with np.errstate(over="ignore"):
                if not np.isfinite(np.array(numbers, np.float32)).all():
                    raise MessageError(f"a value that is not finite: {_not_finite(numbers)}")
            self._values[rows] = numbers
        except MessageError as error:
            for episode in set(self._episode_of[rows].tolist()):
                self._filled.wrong.setdefault(episode, f"{source.topic}, at {at}: {error}")

    def finish(self) -> None:
        """Nothing waits."""


class _Pictures:
    """Puts one camera's pictures into its video, in the order of the frames."""

    def __init__(
        self, plan: BagPlan, key: str, picks: Ints, video: VideoWriter | None, filled: Filled,
        episode_of: Ints,
    ) -> None:  # fmt: skip
        self._plan, self._key, self._video = plan, key, video
        self._wanted, self._picks, self._episode_of = _Wanted(picks), picks, episode_of
        self._filled = filled
        self._places: list[tuple[dict[str, Any], Stats]] = filled.videos.setdefault(key, [])
        self._sizes: dict[int, Size] = filled.sizes.setdefault(key, {})
        self._held: dict[int, tuple[Source, bytes, str]] = {}
        self._bytes = 0
        self._frame = 0  # the next one

    def take(self, place: int, source: Source, data: bytes, at: str) -> None:
        if self._wanted.rows(place) is None:
            return
        self._held[place] = source, data, at
        self._bytes += len(data)
        if self._bytes > MOST_HELD and self._picks[self._frame] not in self._held:
            raise DataError(
                "pictures too far out of order; `mcap sort` puts them in order",
                file=self._plan.index.bag.path, column=source.topic,
                found=f"{len(self._held)} pictures, {self._bytes} bytes, before that of "
                f"{self._plan.index.at(self._time())}",
            )  # fmt: skip
        while (
            self._frame < len(self._picks) and (now := int(self._picks[self._frame])) in self._held
        ):
            self._give(now)

    def finish(self) -> None:
        """All pictures that were planned have come, unless the file was changed meanwhile."""
        if self._frame < len(self._picks):
            raise DataError("changed while it was read", file=self._plan.index.bag.path)

    def _give(self, place: int) -> None:
        """One picture to all of its frames, which stand one after the other."""
        source, data, at = self._held.pop(place)
        self._bytes -= len(data)
        beyond = self._frame + 1
        while beyond < len(self._picks) and self._picks[beyond] == place:
            beyond += 1
        image = wrong = None
        try:
            image = picture(source.decode(data))
        except MessageError as error:
            wrong = str(error)
        for frame in range(self._frame, beyond):
            self._put(frame, image, f"{source.topic}, at {at}: ", wrong)
        self._frame = beyond

    def _put(self, frame: int, image: Any, where: str, wrong: str | None) -> None:
        episode = int(self._episode_of[frame])
        if image is not None:
            size = self._sizes.setdefault(episode, image.size)
            if size != image.size:
                wrong = (f"pictures of {size[0]} x {size[1]} become {image.size[0]} x "
                         f"{image.size[1]}")  # fmt: skip
        if wrong is not None:
            self._filled.wrong.setdefault(episode, where + wrong)
        if self._video is None or self._filled.wrong or image is None:
            return
        shape = self._video.shape
        if shape is not None and image.size != (shape[1], shape[0]):
            self._video = None  # which size is the usual one is known at the end
            return
        if frame == 0 or self._episode_of[frame - 1] != episode:
            self._video.begin()
        try:
            self._video.add(image)
        except ValueError as error:
            raise DataError(f"{error}", file=self._plan.index.bag.path, column=self._key) from error
        if frame + 1 == len(self._picks) or self._episode_of[frame + 1] != episode:
            self._places.append(self._video.end())

    def _time(self) -> int:
        return self._plan.episodes[int(self._episode_of[self._frame])].start


def _not_finite(numbers: list[float]) -> str:
    return ", ".join(f"{v} in place {i}" for i, v in enumerate(numbers)
                     if not np.isfinite(np.float32(v)))  # fmt: skip
