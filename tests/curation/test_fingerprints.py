"""Hashes of rows are equal where values are, and what is in common is what a loop would find."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from lfr.curation.diff.fingerprints import digest, numbers, row_hashes
from lfr.curation.diff.in_common import in_common, offset, overlap

WIDE = pa.large_list(pa.float64())
values_of = arrays.arrays(
    np.float32, st.tuples(st.integers(1, 20), st.integers(1, 4)),
    elements=st.sampled_from([0.0, -0.0, 1.0, 0.1, float("nan"), float("inf"), 3e38, 1e-45]),
)  # fmt: skip


@given(values_of, st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None)
def test_rows_have_one_hash_if_they_are_equal(values: np.ndarray, random: object) -> None:
    size = values.shape[1]
    rows = row_hashes(pa.array(list(values), pa.list_(pa.float32(), size)))
    assert np.array_equal(rows, row_hashes(pa.array(values.tolist(), WIDE)))
    for i, one in enumerate(values):
        for j, other in enumerate(values):
            equal = np.array_equal(one, other, equal_nan=True)
            assert (rows[i] == rows[j]) == equal


def test_a_row_is_the_same_in_every_type() -> None:
    plain = [0, 1, 1, 0]
    of = [row_hashes(pa.array(plain, kind)) for kind in (
        pa.int64(), pa.uint8(), pa.float16(), pa.float64())]  # fmt: skip
    of.append(row_hashes(pa.array([bool(x) for x in plain])))
    of.append(row_hashes(pa.array([[x] for x in plain], pa.list_(pa.int32()))))
    of.append(row_hashes(pa.array([[[x]] for x in plain], pa.list_(pa.list_(pa.int8(), 1), 1))))
    assert all(np.array_equal(each, of[0]) for each in of)
    assert of[0][0] != of[0][1]


@pytest.mark.parametrize("value", [2**53, -(2**53), 2**62])
def test_whole_numbers_that_no_float_can_tell_apart(value: int) -> None:
    one, other, again = (
        row_hashes(pa.array([v], pa.int64()))[0] for v in (value, value + 1, value)
    )
    assert one != other
    assert one == again


def test_order_and_dimension_count() -> None:
    hashes = row_hashes(pa.array([[1.0, 2.0], [2.0, 1.0], [1.0, 2.0]], pa.list_(pa.float32(), 2)))
    assert hashes[0] != hashes[1]
    assert digest([hashes[:2]]) != digest([hashes[1:]])
    assert digest([hashes[:1], hashes[1:]]) != digest([hashes[:2], hashes[2:]])


def test_what_is_no_number_has_a_hash_by_its_content() -> None:
    words = row_hashes(pa.array(["a", "b", "a", None]))
    assert words[0] == words[2]
    assert len(set(words.tolist())) == 3
    kind = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
    pictures = [{"bytes": b"x", "path": "1"}, {"bytes": b"x", "path": "2"},
                {"bytes": b"y", "path": "1"}]  # fmt: skip
    found = row_hashes(pa.array(pictures, kind))
    assert found[0] == found[1] != found[2]
    ragged = pa.array([[1.0], [1.0, 2.0]], pa.list_(pa.float32()))
    assert numbers(ragged) is None
    assert len(set(row_hashes(ragged).tolist())) == 2


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 3)), max_size=40),
       st.lists(st.tuples(st.integers(0, 9), st.integers(0, 3)), max_size=40))  # fmt: skip
@settings(max_examples=200, deadline=None)
def test_rows_in_common_are_those_that_a_loop_finds(
    a: list[tuple[int, int]], b: list[tuple[int, int]]
) -> None:
    def located(rows: list[tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
        return (np.array([h for h, _ in rows], np.uint64), np.array([e for _, e in rows], np.int64))

    expected: dict[tuple[int, int], int] = {}
    for value in range(10):
        owners = [{e for h, e in rows if h == value} for rows in (a, b)]
        if len(owners[0]) == len(owners[1]) == 1:
            pair = (owners[0].pop(), owners[1].pop())
            count = min(sum(h == value for h, _ in rows) for rows in (a, b))
            expected[pair] = expected.get(pair, 0) + count
    pairs, counts = in_common(located(a), located(b))
    assert {tuple(p): c for p, c in zip(pairs.tolist(), counts.tolist(), strict=True)} == expected


@given(st.integers(-6, 6), st.integers(8, 20), st.integers(8, 20))
@settings(max_examples=100, deadline=None)
def test_the_offset_of_two_stretches(shift: int, length_a: int, length_b: int) -> None:
    whole = np.random.default_rng(0).permutation(60).astype(np.uint64)
    a, b = whole[20 : 20 + length_a], whole[20 + shift : 20 + shift + length_b]
    assert offset(a, b) == shift
    x, y = overlap(shift, length_a, length_b)
    assert np.array_equal(a[x], b[y])
    assert len(a[x]) == len(set(a.tolist()) & set(b.tolist()))
