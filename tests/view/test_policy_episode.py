"""Skills and their Gaussians, drawn and read back."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.view.latent import SPAN, UNIT
from lfr.view.policy_episode import save_policy_episode
from lfr.view.trace import SkillTrace

from . import rrd
from .conftest import Recorded

K, Z = 3, 4


@pytest.fixture
def trace() -> SkillTrace:
    rng = np.random.default_rng(1)
    values = [rng.normal(0, 0.5, (K, Z)) for _ in range(7)]
    return SkillTrace(np.array([0, 4, 8]), *values)


def test_divergence_is_torchs_kl(trace: SkillTrace) -> None:
    def normal(mu: np.ndarray, log_sigma: np.ndarray) -> torch.distributions.Normal:
        return torch.distributions.Normal(torch.tensor(mu), torch.tensor(log_sigma).exp())

    policy = normal(trace.policy_mu, trace.policy_log_sigma)
    mapped = normal(trace.mapped_mu, trace.mapped_log_sigma)
    expected = torch.distributions.kl_divergence(policy, mapped).sum(1)
    np.testing.assert_allclose(trace.divergence, expected.numpy(), rtol=1e-12)


def test_shapes_must_agree(trace: SkillTrace) -> None:
    with pytest.raises(ValueError, match="mapped_mu has shape"):
        replace(trace, mapped_mu=np.zeros((K, Z + 1)))


def test_a_policys_recording(recorded: Recorded, trace: SkillTrace, tmp_path: Path) -> None:
    path = tmp_path / "policy.rrd"
    save_policy_episode(path, recorded.episode, trace, recorded.poses)
    entities = rrd.read(path)
    frames, chosen = entities["/skill/dimension/2"]["Scalars:scalars"]
    assert frames is not None
    np.testing.assert_array_equal(frames, trace.skill_start)
    expected = [trace.z[:, 2], trace.policy_mu[:, 2], trace.mapped_mu[:, 2]]
    np.testing.assert_array_equal(np.array(chosen), np.stack(expected, axis=1))
    bars = np.array(entities["/latent/target/policy/spread"]["LineStrips2D:strips"][1])
    assert bars.shape == (K, Z, 2, 2)
    heights = -bars[..., 1] / UNIT
    sigma = np.exp(trace.policy_log_sigma)
    for end, sign in ((0, -1), (1, 1)):
        value = np.clip(trace.policy_mu + sign * sigma, -SPAN, SPAN)
        np.testing.assert_allclose(heights[:, :, end], value, atol=1e-5)
    assert len(entities["/path/skill"]["LineStrips3D:strips"][1]) == K
