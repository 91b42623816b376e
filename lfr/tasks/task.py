"""What a task is: its scene, what is observed in it, its reward, and how it is demonstrated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from lfr import spaces
from lfr.compiled import observation
from lfr.spaces import Quantity, Space
from lfr.tasks.waypoints import View, Waypoint


@dataclass(frozen=True)
class Place:
    """Something of a scene that has a position: a body or a site of the MJCF, or a fixed point."""

    kind: Literal["body", "site", "point"]
    name: str


EEF = Place("site", "eef")
"""The grip site, of whichever arm and gripper."""


@dataclass(frozen=True)
class Term:
    """One quantity of `observation.environment_state`, and what it is taken from.

    Attributes:
        quantity: what it is.
        kind: one of `lfr.compiled.observation`.
        to: the place that it is of.
        origin: the place that it is relative to.
    """

    quantity: Quantity
    kind: int
    to: Place
    origin: Place = EEF


def position(thing: str, place: Place) -> Term:
    """Position of a thing, m, base frame."""
    return Term(spaces.position(thing), observation.POSITION, place)


def axis(thing: str, place: Place) -> Term:
    """A thing's own z axis, base frame."""
    return Term(spaces.axis(thing), observation.AXIS, place)


def displacement(start: str, origin: Place, end: str, to: Place) -> Term:
    """The vector from one thing to another, m, base frame."""
    return Term(spaces.displacement(start, end), observation.DISPLACEMENT, to, origin)


def yaw(
    name: str,
    turned: str,
    to: Place,
    fold: int,
    origin: Place = EEF,
    reference: str = "the gripper",
) -> Term:
    """Cosine and sine of ``fold`` times the yaw of a thing's x axis relative to a reference's."""
    return Term(spaces.yaw(name, turned, reference, fold), observation.YAW, to, origin)


@dataclass(frozen=True)
class Sized:
    """A box whose size is drawn for each episode.

    Attributes:
        body: its root body in robosuite's MJCF.
        low, high: bounds of its half sizes, m.
    """

    body: str
    low: float
    high: float


@dataclass(frozen=True)
class Task:
    """One robosuite task for one arm.

    Attributes:
        name: this project's name of the task.
        stock_name: robosuite's name of it.
        horizon: control steps (20 Hz) after which an episode ends.
        instruction: the task in words, for datasets.
        objects: observed object -> its root body in robosuite's MJCF, the manipulated one first.
        places: what the terms and the reward are about, the manipulated object first; compiled
            code numbers them from 1, and `EEF` is 0.
        terms: of `observation.environment_state`, in order.
        constants: of robosuite's environment of this task, the numbers that `reward` reads from
            `SceneArrays.constants`.
        points: of the same, where the fixed places of ``terms`` are, (3,) m, world frame.
        reward: compiled, (physics, scene) -> (robosuite's dense reward, its success check), of the
            state that the last substep started from.
        waypoint: where the gripper of a demonstrator should go next.
        sized: the object whose size is drawn, if there is one.
        unused_objects: root bodies that robosuite builds and parks away from the scene.
        stock_options: further keyword arguments of robosuite's environment.
    """

    name: str
    stock_name: str
    horizon: int
    instruction: str
    objects: dict[str, str]
    places: tuple[Place, ...]
    terms: tuple[Term, ...]
    constants: Callable[[Any], tuple[float, ...]]
    reward: Callable[..., tuple[float, bool]]
    waypoint: Callable[[View], Waypoint]
    points: Callable[[Any], Mapping[str, Any]] = field(default=lambda environment: {})
    sized: Sized | None = None
    unused_objects: tuple[str, ...] = ()
    stock_options: dict[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for term in self.terms:
            for place in {term.to, term.origin} - {EEF, *self.places}:
                raise ValueError(f"{self.name}: {place} of {term.quantity.name} is no place of it")
            turned = term.kind in (observation.AXIS, observation.YAW)
            if turned and "point" in (term.to.kind, term.origin.kind):
                raise ValueError(f"{self.name}: {term.quantity.name} of a point, which has no axes")

    @property
    def environment(self) -> Space:
        """`observation.environment_state`."""
        return Space(tuple(term.quantity for term in self.terms))

    @property
    def observation(self) -> Space:
        """`observation.state`, then `observation.environment_state`."""
        return spaces.ROBOT_STATE + self.environment

    @property
    def manipulated(self) -> str:
        """The object that is manipulated."""
        return next(iter(self.objects))


def manipulated_object(name: str, body: Place, fold: int | None = None) -> tuple[Term, ...]:
    """What is observed of the object that is manipulated: pose, and the way to it from the hand.

    Args:
        fold: rotational symmetry about its z axis; None for one whose yaw cannot be seen.
    """
    terms = (position(name, body), axis(name, body), displacement("eef", EEF, name, body))
    return terms if fold is None else (*terms, yaw(name, name, body, fold))
