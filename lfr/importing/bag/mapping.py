"""Which topics of a bag make which feature: the file that `lfr columns BAG` proposes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from lfr.data.episode import ACTION, IMAGES
from lfr.errors import ParameterError
from lfr.importing.bag.values import steps
from lfr.params import read_yaml
from lfr.records import from_mapping

Method = Literal["nearest", "previous", "hold"]
Clock = Literal["header", "log", "publish"]
Late = Literal["refuse", "cut"]
FASTEST = 1000  # frames per second
OBSERVATION = "observation."


@dataclass(frozen=True)
class Part:
    """What a feature, or a part of it, is read from.

    Attributes:
        topic: of its messages.
        field: dotted path of its numbers in a message; "" takes all. A picture has none.
        names: which numbers in which order, where the message names them as it does joints: one
            that is missing is an error, further ones are left out. Elsewhere what they are called.
        prefix: put before each name, so that the joints of two arms can be told apart.
        method: a frame takes the message "nearest" to its time; or the "previous" one, the last up
            to it, which never looks ahead; or that one however old it is, "hold", for a topic that
            speaks only when something changes.
        tolerance: seconds between a frame and its message above which that is missing. By default
            the mapping's, or else one frame of "nearest" and two of "previous".
    """

    topic: str
    field: str = ""
    names: tuple[str, ...] | None = None
    prefix: str = ""
    method: Method = "nearest"
    tolerance: float | None = None

    def __post_init__(self) -> None:
        steps(self.field)
        _check_tolerance(self.tolerance)
        if self.method == "hold" and self.tolerance is not None:
            raise ValueError("a method that holds has no tolerance")
        if self.names is not None and len(set(self.names)) < max(1, len(self.names)):
            raise ValueError(f"names are to be different ones, found {list(self.names)}")


@dataclass(frozen=True)
class Next:
    """A feature that is another one's value in the next frame; an episode has one frame less.

    Attributes:
        next: that feature.
        names: which of its dimensions; None takes all.
    """

    next: str
    names: tuple[str, ...] | None = None


@dataclass(frozen=True)
class TaskTopic:
    """The instruction from a topic: the last text up to an episode's first frame, or else its
    first."""

    topic: str
    field: str = "data"


@dataclass(frozen=True)
class Episodes:
    """Where episodes begin and end: with each bag, or by one of two other rules.

    Attributes:
        gap: seconds in which all topics are silent, which part two episodes.
        topic, field: of messages that say so: a value `start` begins an episode and `end` ends it.
            Without `end` an episode goes on up to the next `start`.
        late: an episode with a frame for which a message is missing is a "refuse"d one, or "cut"
            there into several.
    """

    gap: float | None = None
    topic: str | None = None
    field: str = "data"
    start: bool | int | float | str | None = None
    end: bool | int | float | str | None = None
    late: Late = "refuse"

    def __post_init__(self) -> None:
        if self.gap is not None and self.topic is not None:
            raise ValueError("gap and topic are two ways to find episodes; keep one")
        if self.gap is not None and not self.gap > 0:
            raise ValueError(f"gap is seconds above 0, found {self.gap}")
        if (self.topic is None) != (self.start is None) or (self.topic is None and self.end):
            raise ValueError("topic and start belong together, end goes with them")


@dataclass(frozen=True)
class BagMapping:
    """A mapping file.

    Attributes:
        fps: frames per second of the dataset.
        features: by key; `action` is among them. Several parts stand one after the other.
        task: the instruction, or where it is said.
        robot_type: what the dataset calls the robot.
        time: when a message is: its "header" stamp, when it was recorded ("log") or "publish"ed;
            None takes the headers where every feature has them.
        tolerance: as a part's, for all that say none.
        episodes: how they are found.
    """

    fps: int
    features: dict[str, Part | tuple[Part, ...] | Next]
    task: str | TaskTopic
    robot_type: str = "unknown"
    time: Clock | None = None
    tolerance: float | None = None
    episodes: Episodes = field(default_factory=Episodes)

    def __post_init__(self) -> None:
        if not 1 <= self.fps <= FASTEST:
            raise ValueError(f"fps is 1 to {FASTEST}, found {self.fps}")
        _check_tolerance(self.tolerance)
        if isinstance(self.task, str) and not self.task.strip():
            raise ValueError("task is empty; say in words what is done")
        if ACTION not in self.features:
            raise ValueError(f"no feature {ACTION!r}; {{next: observation.state}} makes one of "
                             f"the next state; found: {', '.join(self.features)}")  # fmt: skip
        for key, feature in self.features.items():
            self._check(key, feature)

    def _check(self, key: str, feature: Part | tuple[Part, ...] | Next) -> None:
        if "/" in key or not (key == ACTION or key.startswith(OBSERVATION)):
            raise ValueError(f"no name of a feature: {key!r}; such as observation.state, "
                             f"{IMAGES}front or {ACTION}")  # fmt: skip
        if isinstance(feature, Next):
            if is_image(key) or feature.next not in self.numbers:
                raise ValueError(f"{key}: next is {feature.next!r}; valid: "
                                 f"{', '.join(self.numbers) or '(none)'}")  # fmt: skip
        elif not (parts := _parts(feature)):
            raise ValueError(f"{key}: no parts")
        elif is_image(key) and (len(parts) > 1 or any(part.field or part.names for part in parts)):
            raise ValueError(f"{key}: pictures have one topic, no field and no names")

    @property
    def numbers(self) -> dict[str, tuple[Part, ...]]:
        """The features that are read from messages and no pictures."""
        return {k: parts for k, f in self.features.items() if (parts := _parts(f))
                and not is_image(k)}  # fmt: skip

    @property
    def cameras(self) -> dict[str, Part]:
        """The features that are pictures."""
        return {k: _parts(f)[0] for k, f in self.features.items() if is_image(k)}

    @property
    def nexts(self) -> dict[str, Next]:
        return {k: f for k, f in self.features.items() if isinstance(f, Next)}

    @property
    def parts(self) -> tuple[Part, ...]:
        """All parts of all features, each once."""
        return tuple(dict.fromkeys(part for f in self.features.values() for part in _parts(f)))

    def tolerance_of(self, part: Part) -> float:
        """Nanoseconds; infinite where the last message holds."""
        if part.method == "hold":
            return math.inf
        own = self.tolerance if part.tolerance is None else part.tolerance
        frames = 1 if part.method == "nearest" else 2
        return (frames / self.fps if own is None else own) * 1e9


def is_image(key: str) -> bool:
    return key.startswith(IMAGES)


def _parts(feature: Part | tuple[Part, ...] | Next) -> tuple[Part, ...]:
    return (feature,) if isinstance(feature, Part) else () if isinstance(feature, Next) else feature


def read_mapping(path: Path) -> BagMapping:
    """A mapping file's content.

    Raises:
        ParameterError: it is missing, no YAML, or has a key that is unknown, missing or wrong.
    """
    if not path.is_file():
        raise ParameterError(f"{path} is missing; `lfr columns BAG` proposes a mapping")
    return from_mapping(BagMapping, read_yaml(path), f"{path}: mapping")


def _check_tolerance(tolerance: float | None) -> None:
    if tolerance is not None and not 0 < tolerance < math.inf:  # nan too
        raise ValueError(f"tolerance is seconds above 0, found {tolerance}")
