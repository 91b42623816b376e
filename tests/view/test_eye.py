"""What the eye of the 3-D view sees, by a pinhole camera's projection."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lfr.view.eye import FIELD_OF_VIEW, MARGIN, eye_on

metres = st.floats(-2.0, 2.0, width=32)


@given(arrays(np.float64, st.tuples(st.integers(1, 20), st.just(3)), elements=metres))
def test_every_point_is_in_the_picture_and_none_could_be_nearer(points: np.ndarray) -> None:
    eye = eye_on(points)
    forward = eye.target - eye.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    offset = points - eye.position
    depth = offset @ forward
    edge = np.tan(FIELD_OF_VIEW / 2) * depth  # half of what the picture spans there, in m
    aside = np.stack([offset @ right, offset @ np.cross(right, forward)], axis=1)
    room = edge[:, None] - np.abs(aside)
    assert (depth > 0).all()
    assert room.min() > MARGIN - 1e-6
    assert room.min() < MARGIN + 1e-6
