"""All episodes at once give what each gives alone."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lfr.curation.exact_stats import dataset_stats, episode_stats
from lfr.data.stats import vector_stats


@settings(max_examples=50)
@given(
    lengths=st.lists(st.integers(1, 12), min_size=1, max_size=8),
    dimensions=st.integers(0, 4),
    seed=st.integers(0, 2**16),
    kind=st.sampled_from([np.float32, np.int64, np.bool_]),
)
def test_episodes_at_once_are_episodes_alone(
    lengths: list[int], dimensions: int, seed: int, kind: type
) -> None:
    shape = (sum(lengths), dimensions) if dimensions else (sum(lengths),)
    values = (3 * np.random.default_rng(seed).normal(size=shape)).astype(kind)
    ends = np.cumsum(lengths)
    found = episode_stats(values, np.array(lengths), bounds=True)
    for i, end in enumerate(ends):
        for name, expected in vector_stats(values[end - lengths[i] : end]).items():
            np.testing.assert_allclose(found[name][i], expected, rtol=1e-12, atol=1e-12)
            if name.startswith("q"):
                assert (found[f"{name}/low"][i] <= expected).all()
                assert (found[f"{name}/high"][i] >= expected).all()
    for name, expected in vector_stats(values).items():
        np.testing.assert_allclose(dataset_stats(values)[name], expected, rtol=1e-12, atol=1e-12)
