"""The kernel's generator against NumPy's own."""

import numba
import numpy as np
import pytest

from lfr.sim import pcg64
from lfr.sim.compilation import make_callable

make_callable()

SEEDS = [0, 1, 5, 2**31 - 1, 2**32 - 1, 2**32, 1_500_000, 2_000_099, 2**63, 2**64 - 1]


@numba.njit
def seeded(seed, state):  # type: ignore[no-untyped-def]
    pcg64.seed_generator(seed, state)


@numba.njit
def drawn(seed, state, uniforms, normals):  # type: ignore[no-untyped-def]
    pcg64.seed_generator(seed, state)
    for i in range(len(normals)):
        normals[i] = pcg64.normal(state)
        uniforms[i] = pcg64.uniform(state)


@pytest.mark.parametrize("seed", SEEDS)
def test_state_and_draws_are_numpys(seed: int) -> None:
    theirs = np.random.default_rng(seed)
    kept = theirs.bit_generator.state["state"]
    state = pcg64.generator()
    seeded(np.uint64(seed), state)
    words = [int(word) for word in state[:4]]
    assert (words[0] << 64) + words[1] == kept["state"]
    assert (words[2] << 64) + words[3] == kept["inc"]
    uniforms, normals = np.empty((2, 20_000))  # so many that the ziggurat's edges and tail occur
    drawn(np.uint64(seed), pcg64.generator(), uniforms, normals)
    expected = np.array([(theirs.standard_normal(), theirs.random()) for _ in range(20_000)])
    np.testing.assert_array_equal(normals, expected[:, 0])
    np.testing.assert_array_equal(uniforms, expected[:, 1])
