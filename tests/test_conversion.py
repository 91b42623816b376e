"""Conversions of what is observed, against SciPy's rotations and sums written out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lfr.columns import Part
from lfr.conversion import Conversion

POSE = ("hand_pos.x", "hand_pos.y", "hand_pos.z")
TURN = tuple(f"hand_rot6d.{i}" for i in range(6))
QUARTER = (0.75, -0.74, -0.4, 0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))  # about the vertical


def test_units_zeros_and_signs() -> None:
    degrees = Part("observation.state", names=("joint.a",), unit="deg").conversion
    np.testing.assert_allclose(degrees(np.array([[180.0]]), ("joint.a",)), [[np.pi]])
    millimetres = Part("observation.state", names=POSE, unit="mm").conversion
    np.testing.assert_allclose(millimetres(np.array([1.0, 20.0, 300.0]), POSE), [0.001, 0.02, 0.3])
    # 0 closed and 1 open becomes 1 closed and -1 open
    gripper = Part("observation.state", names=("gripper_command",), zero=0.5, unit=-0.5).conversion
    closed_open = np.array([[0.0], [1.0]])
    np.testing.assert_array_equal(gripper(closed_open, ("gripper_command",)), [[1.0], [-1.0]])
    each = Conversion(zero=(0.0, 0.0, 0.1))
    np.testing.assert_allclose(each(np.array([1.0, 2.0, 3.0]), POSE), [1.0, 2.0, 2.9])


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_quaternions_become_the_columns_of_their_matrix(order: str) -> None:
    rotations = Rotation.random(50, random_state=0)
    given_as = rotations.as_quat(scalar_first=order == "wxyz")
    convert = Conversion(quaternion=order)  # type: ignore[arg-type]
    expected = np.concatenate([rotations.as_matrix()[:, :, i] for i in (0, 1)], axis=1)
    for sign in (1, -1):  # one rotation has two quaternions
        np.testing.assert_allclose(convert(sign * given_as, TURN), expected, atol=1e-12)
    with pytest.raises(ValueError, match=r"no unit quaternion: .* in row 1"):
        convert(given_as[:2] * [[1.0], [1.1]], TURN)


def test_a_frame_moves_points_turns_vectors_and_leaves_the_rest() -> None:
    names = (*POSE, "hand_to_cube.x", "hand_to_cube.y", "hand_to_cube.z", *TURN,
             "gripper_aperture", "joint.a", "cube_yaw.cos", "cube_yaw.sin")  # fmt: skip
    values = np.random.default_rng(0).normal(size=(7, len(names)))
    found = Conversion(frame=QUARTER)(values, names)
    expected = values.copy()
    expected[:, 0], expected[:, 1] = 0.75 - values[:, 1], values[:, 0] - 0.74
    expected[:, 2] = values[:, 2] - 0.4
    for start in (3, 6, 9):  # the vector, and the two columns of a matrix
        expected[:, start], expected[:, start + 1] = -values[:, start + 1], values[:, start]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_rotation_in_a_frame_is_the_product_of_both() -> None:
    frame, hand = Rotation.random(random_state=1), Rotation.random(20, random_state=2)
    convert = Conversion(quaternion="xyzw", frame=(0.0, 0.0, 0.0, *frame.as_quat()))
    matrices = (frame * hand).as_matrix()
    expected = np.concatenate([matrices[:, :, 0], matrices[:, :, 1]], axis=1)
    np.testing.assert_allclose(convert(hand.as_quat(), TURN), expected, atol=1e-12)


@given(
    st.lists(st.floats(-5, 5), min_size=6, max_size=6),
    st.floats(0.1, 3) | st.floats(-3, -0.1), st.floats(-1, 1), st.integers(0, 99), st.booleans(),
)  # fmt: skip
def test_bounds_hold_all_that_lies_within_them(
    ends: list[float], unit: float, zero: float, seed: int, framed: bool
) -> None:
    low, high = np.minimum(ends[:3], ends[3:]), np.maximum(ends[:3], ends[3:])
    turn = Rotation.random(random_state=seed).as_quat()
    convert = Conversion(zero, unit, frame=(1.0, 2.0, 3.0, *turn) if framed else ())
    least, most = convert.bounds(low, high, POSE)
    inside = np.random.default_rng(seed).uniform(low, high, (100, 3))
    found = convert(inside, POSE)
    assert (found >= least - 1e-9).all()
    assert (found <= most + 1e-9).all()


@pytest.mark.parametrize(
    ("made", "names", "message"),
    [
        ({"quaternion": "xyzw"}, POSE, "a quaternion becomes <thing>_rot6d.0 to .5, found hand_p"),
        (
            {"frame": QUARTER},
            POSE[:2],
            "turned as a whole, found hand_pos.x, hand_pos.y",
        ),
        ({"frame": (0, 0, 0, 1, 0, 0, 0)}, ("a_yaw.cos", "a_yaw.sin"), "about the vertical"),
        ({"zero": (1.0, 2.0)}, POSE, "zero: found 2 numbers for 3"),
        ({"frame": (1.0, 2.0)}, POSE, "frame is x, y, z, qx, qy, qz, qw, found 2 numbers"),
        ({"frame": (0, 0, 0, 0, 0, 0, 2)}, POSE, "frame ends in a unit quaternion"),
        ({"unit": 0.0}, POSE, "unit must not be 0"),
        ({"zero": float("nan")}, POSE, "unit must not be 0, nor endless"),
    ],
)
def test_what_cannot_be_is_told(
    made: dict[str, object], names: tuple[str, ...], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        Conversion(**made).check(names)  # type: ignore[arg-type]
