"""From a column's numbers to the quantities that models know: units, rotations and frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lfr.spaces import space

UNITS = {"m": 1.0, "cm": 100.0, "mm": 1000.0, "rad": 1.0, "deg": 180.0 / math.pi}
"""How many of a unit a metre or radian has."""

UNIT_TOLERANCE = 1e-2  # of a quaternion's norm, which three digits may have been left of
TURNED = ("point", "vector", "axial", "rotation")  # another in another frame
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Conversion:
    """What is done to the numbers of one part of an observation, in this order.

    Attributes:
        zero: what 0 is in the column, of all numbers or of each, subtracted.
        unit: the size of a metre, of a radian or of whatever 1 stands for, divided by.
        quaternion: the order of four numbers that are a unit quaternion; they become the first two
            columns of its matrix. "" where there is none.
        frame: pose (x, y, z, qx, qy, qz, qw), in m, of the column's frame in that of the
            observation; () where it is the same.
    """

    zero: float | tuple[float, ...] = 0.0
    unit: float = 1.0
    quaternion: Literal["", "xyzw", "wxyz"] = ""
    frame: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not (self.unit != 0 and np.isfinite([self.unit, *np.atleast_1d(self.zero)]).all()):
            raise ValueError(f"unit must not be 0, nor endless, found {self.unit}")
        if self.frame and len(self.frame) != 7:
            raise ValueError(f"frame is x, y, z, qx, qy, qz, qw, found {len(self.frame)} numbers")
        if self.frame and abs(np.linalg.norm(self.frame[3:]) - 1.0) > UNIT_TOLERANCE:
            raise ValueError(f"frame ends in a unit quaternion, found {list(self.frame[3:])}")

    @property
    def sizes(self) -> tuple[int, int] | None:
        """How many numbers become how many; None: as many as there are."""
        return (4, 6) if self.quaternion else None

    def check(self, names: Sequence[str]) -> None:
        """Raises ValueError where it cannot make quantities called ``names``, saying which."""
        size = 4 if self.quaternion else len(names)
        if isinstance(self.zero, tuple) and len(self.zero) != size:
            raise ValueError(f"zero: found {len(self.zero)} numbers for {size}")
        made = [(one.moves, one.size) for one in space(names).quantities]
        if self.quaternion and made != [("rotation", 6)]:
            said = ", ".join(names)
            raise ValueError(f"a quaternion becomes <thing>_rot6d.0 to .5, found {said}")
        if self.frame:
            _moved(self.frame, tuple(names))

    def __call__(self, values: NDArray, names: Sequence[str]) -> NDArray:
        """Numbers (..., n) of the column as the quantities called ``names`` (..., m).

        Raises:
            ValueError: no unit quaternion.
        """
        if self.zero:
            values = np.asarray(values, np.float64) - np.array(self.zero)
        if self.unit != 1.0:
            values = values / self.unit
        if self.quaternion:
            values = _rot6d(np.asarray(values, np.float64), self.quaternion)
        if self.frame:
            turn, shift = _moved(self.frame, tuple(names))
            values = values @ turn.T + shift
        return values

    def bounds(self, low: Array, high: Array, names: Sequence[str]) -> tuple[Array, Array]:
        """Bounds (m,) of the quantities whose numbers in the column lie within bounds (n,)."""
        if self.quaternion:
            low, high = -np.ones(6), np.ones(6)
        else:
            zero = np.array(self.zero)
            ends = (low - zero) / self.unit, (high - zero) / self.unit
            low, high = np.minimum(*ends), np.maximum(*ends)
        if not self.frame:
            return low, high
        turn, shift = _moved(self.frame, tuple(names))
        middle, half = turn @ (low + high) / 2 + shift, np.abs(turn) @ (high - low) / 2
        return middle - half, middle + half


AS_IT_IS = Conversion()


def _rot6d(values: Array, order: str) -> Array:
    """(..., 6): the first column of each rotation matrix, then the second."""
    from scipy.spatial.transform import Rotation

    flat = values.reshape(-1, 4)
    norms = np.linalg.norm(flat, axis=1)
    wrong = ~(np.abs(norms - 1.0) <= UNIT_TOLERANCE)
    if wrong.any():
        row = int(wrong.argmax())
        raise ValueError(f"no unit quaternion: {flat[row].tolist()} in row {row}")
    matrices = Rotation.from_quat(flat, scalar_first=order == "wxyz").as_matrix()
    return matrices[:, :, :2].transpose(0, 2, 1).reshape(*values.shape[:-1], 6)


@cache
def _moved(frame: tuple[float, ...], names: tuple[str, ...]) -> tuple[Array, Array]:
    """(m, m) and (m,): quantities in the frame are these times them, plus those, outside of it."""
    from scipy.spatial.transform import Rotation

    rotation = Rotation.from_quat(frame[3:]).as_matrix()
    turn, shift = np.eye(len(names)), np.zeros(len(names))
    for found, place in space(names).items():
        if found.moves == "relative angle" and not np.allclose(rotation[2, 2], 1.0, atol=1e-6):
            raise ValueError(f"{found.name} is about the vertical, which the frame's turn changes")
        if found.moves not in TURNED:
            continue
        if found.size % 3 or found.size != (6 if found.moves == "rotation" else 3):
            raise ValueError(f"{found.name} is turned as a whole, found {', '.join(found.names)}")
        turn[place, place] = np.kron(np.eye(found.size // 3), rotation)
        if found.moves == "point":
            shift[place] = frame[:3]
    return turn, shift
