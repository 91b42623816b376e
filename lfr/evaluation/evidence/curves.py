"""Learning curves: what their area and their first good evaluation say of the speed of learning."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from lfr.errors import DataError

LEVELS = (0.5, 0.8, 0.95)  # of success, whose first steps are reported


@dataclass(frozen=True)
class Curve:
    """The running evaluations of one run, on a few starts each.

    Attributes:
        env_steps: before each evaluation, rising; the first is 0, before learning.
        success: the share of its episodes that succeeded.
    """

    env_steps: tuple[int, ...]
    success: tuple[float, ...]

    def __post_init__(self) -> None:
        steps = self.env_steps
        if len(steps) < 2 or len(steps) != len(self.success) or steps[0] != 0:
            raise ValueError(f"a curve at environment steps {steps}; expected 0 and more")
        if any(after <= before for before, after in pairwise(steps)):
            raise ValueError(f"environment steps {steps} do not rise")

    @property
    def area(self) -> float:
        """The area under the curve by the trapezoid rule, over the last step: in [0, 1]."""
        return float(np.trapezoid(self.success, self.env_steps)) / self.env_steps[-1]

    def first_at(self, level: float) -> int | None:
        """Environment steps at the first evaluation that reaches ``level``; None if none does.

        The first evaluation is before learning, so a policy may be there after 0 steps. It need
        not stay there: the area and the final rate tell of what is lost again.
        """
        points = zip(self.env_steps, self.success, strict=True)
        return next((steps for steps, success in points if success >= level), None)


def read_curves(path: Path) -> dict[tuple[str, int], Curve]:
    """A learning stage's CSV: (reward, seed) -> curve.

    Raises:
        DataError: the file is missing, lacks a column, or a curve in it is none.
    """
    found: dict[tuple[str, int], list[tuple[int, float]]] = {}
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            for row in csv.DictReader(stream):
                point = int(float(row["env_steps"])), float(row["success"])
                found.setdefault((row["reward"], int(row["seed"])), []).append(point)
    except FileNotFoundError:
        raise DataError("the file is missing", file=path) from None
    except KeyError as column:
        raise DataError("the file lacks a column", file=path, expected=column.args[0]) from None
    try:
        return {key: Curve(*zip(*points, strict=True)) for key, points in found.items()}
    except ValueError as error:
        raise DataError("no learning curve", file=path, found=error) from None


def median_first(firsts: Sequence[int | None]) -> float | None:
    """The median of `Curve.first_at` over seeds, where never counts as later than any step."""
    middle = float(np.median([math.inf if first is None else first for first in firsts]))
    return middle if math.isfinite(middle) else None


def side_by_side(curves: Iterable[Curve]) -> tuple[np.ndarray, np.ndarray]:
    """Curves of several seeds on one axis.

    Runs are evaluated every so many steps, give or take the skills under way, so their points do
    not quite meet; each curve is read, linearly between its points, at the points of the first, as
    far as all of them go.

    Returns:
        environment steps (P,) and success (P, N).
    """
    each = list(curves)
    end = min(curve.env_steps[-1] for curve in each)
    axis = np.array([*(step for step in each[0].env_steps if step < end), end])
    rates = [np.interp(axis, curve.env_steps, curve.success) for curve in each]
    return axis, np.stack(rates, axis=-1)
