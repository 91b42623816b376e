"""NumPy's default generator, compiled: the same draws from the same seed, bit for bit.

A start is named by its seed, for the engine as for stock robosuite, and `default_rng(seed)` takes
longer than all else that a reset does. Seeding is NumPy's `SeedSequence` (after M. E. O'Neill's
seed_seq_fe), the generator PCG64, a 128-bit LCG with XSL-RR output (O'Neill 2014), and a normal
number comes from NumPy's ziggurat, with the tables that numba keeps of it.
"""

import math

import numpy as np
from numba.np.random._constants import (  # pyright: ignore[reportMissingImports]
    fi_double,
    ki_double,
    wi_double,
    ziggurat_nor_inv_r,
    ziggurat_nor_r,
)
from numpy.typing import NDArray

from lfr.compiled import compiled

State = NDArray[np.uint64]
"""(8,): the LCG's state and its increment, the high word of each first, and the pool of
32-bit words that it is seeded from."""

_MULTIPLIER_HIGH, _MULTIPLIER_LOW = np.uint64(2549297995355413924), np.uint64(4865540595714422341)
_ONE, _SHIFT, _WORD = np.uint64(1), np.uint64(32), np.uint64(0xFFFFFFFF)


def generator() -> State:
    """Room for a generator; `seed_generator` gives it its state."""
    return np.zeros(8, dtype=np.uint64)


@compiled
def seed_generator(seed: int, state: State) -> None:
    """The state of `np.random.default_rng(seed)`, for a seed below 2^64."""
    entropy = np.uint64(seed)
    pool = state[4:]
    constant = np.uint32(0x43B0D7E5)
    for i in range(4):
        word = np.uint32((entropy >> np.uint64(32 * i)) & _WORD) if i < 2 else np.uint32(0)
        pool[i], constant = _hashed(word, constant, np.uint32(0x931E8875))
    for source in range(4):
        for target in range(4):
            if source != target:
                word, constant = _hashed(np.uint32(pool[source]), constant, np.uint32(0x931E8875))
                mixed = np.uint32(
                    np.uint32(0xCA01F9DD) * np.uint32(pool[target]) - np.uint32(0x4973F715) * word
                )
                pool[target] = mixed ^ (mixed >> np.uint32(16))
    constant = np.uint32(0x8B51F9DD)
    for i in range(4):  # the state's high and low half, then the increment's; low word first
        first, second = np.uint32(pool[2 * i % 4]), np.uint32(pool[(2 * i + 1) % 4])
        first, constant = _hashed(first, constant, np.uint32(0x58F38DED))
        second, constant = _hashed(second, constant, np.uint32(0x58F38DED))
        state[i] = np.uint64(first) | (np.uint64(second) << _SHIFT)
    high, low = state[0], state[1]
    state[2] = (state[2] << _ONE) | (state[3] >> np.uint64(63))
    state[3] = (state[3] << _ONE) | _ONE
    state[0], state[1] = np.uint64(0), np.uint64(0)
    _advance(state)
    total = state[1] + low
    state[0] = state[0] + high + (_ONE if total < low else np.uint64(0))
    state[1] = total
    _advance(state)


@compiled
def uniform(state: State) -> float:
    """In [0, 1), as `Generator.random`."""
    return np.float64(_next(state) >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@compiled
def normal(state: State) -> float:
    """Standard normal, as `Generator.standard_normal`."""
    while True:
        bits = _next(state)
        layer = np.int64(bits & np.uint64(0xFF))
        bits >>= np.uint64(8)
        negative = (bits & _ONE) == _ONE
        magnitude = (bits >> _ONE) & np.uint64(0x000FFFFFFFFFFFFF)
        x = np.float64(magnitude) * wi_double[layer]
        if negative:
            x = -x
        if magnitude < ki_double[layer]:
            return x
        if layer == 0:
            while True:
                beyond = -ziggurat_nor_inv_r * math.log1p(-uniform(state))
                height = -math.log1p(-uniform(state))
                if height + height > beyond * beyond:
                    tail = (magnitude >> np.uint64(8)) & _ONE
                    return -(ziggurat_nor_r + beyond) if tail == _ONE else ziggurat_nor_r + beyond
        step = fi_double[layer - 1] - fi_double[layer]
        if step * uniform(state) + fi_double[layer] < math.exp(-0.5 * x * x):
            return x


@compiled
def _hashed(value: np.uint32, constant: np.uint32, multiplier: np.uint32):  # type: ignore[no-untyped-def]
    """The hash of a word, and the constant for the next one."""
    value = np.uint32(value ^ constant)
    constant = np.uint32(constant * multiplier)
    value = np.uint32(value * constant)
    return np.uint32(value ^ (value >> np.uint32(16))), constant


@compiled
def _next(state: State) -> np.uint64:
    _advance(state)
    folded = state[0] ^ state[1]
    turn = state[0] >> np.uint64(58)
    return (folded >> turn) | (folded << ((np.uint64(64) - turn) & np.uint64(63)))


@compiled
def _advance(state: State) -> None:
    """state <- state * multiplier + increment, modulo 2^128."""
    high, low = state[0], state[1]
    product = low * _MULTIPLIER_LOW
    carried = _high_word(low, _MULTIPLIER_LOW)
    total = product + state[3]
    carried += high * _MULTIPLIER_LOW + low * _MULTIPLIER_HIGH + state[2]
    state[0] = carried + (_ONE if total < product else np.uint64(0))
    state[1] = total


@compiled
def _high_word(a: np.uint64, b: np.uint64) -> np.uint64:
    """The upper 64 bits of a * b."""
    a_high, a_low, b_high, b_low = a >> _SHIFT, a & _WORD, b >> _SHIFT, b & _WORD
    crossed = a_high * b_low + ((a_low * b_low) >> _SHIFT)
    middle = a_low * b_high + (crossed & _WORD)
    return a_high * b_high + (crossed >> _SHIFT) + (middle >> _SHIFT)
