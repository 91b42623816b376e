"""The skill VAE: Eq. 2 and 3 by hand, shapes, determinism."""

import pytest
import torch

from lfr.embodiments import embodiment
from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.skills.skill_params import VAEParams
from lfr.skills.skill_training import train_vae
from lfr.skills.vae import SkillVAE, reconstruction_rmse, vae_loss
from lfr.spaces import ROBOT_STATE

OSC = embodiment("panda").action.names
TINY = VAEParams(horizon=4, latent_dim=3, hidden=8, steps=20, batch=8)


def windows(count: int, seed: int = 0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(count, 4, 7, generator=generator) * 2 - 1


def test_loss_is_mean_squared_error_plus_alpha_times_the_summed_divergence() -> None:
    torch.manual_seed(0)
    vae, actions, alpha = SkillVAE(4, 7, 3, 8), windows(6), 0.25
    torch.manual_seed(1)
    loss, info = vae_loss(vae, actions, alpha)

    mu, log_sigma = vae.encode(actions)
    torch.manual_seed(1)
    z = mu + log_sigma.exp() * torch.randn(mu.shape)
    error = 0.0
    decoded = vae.reconstruct(z)
    for b in range(6):
        for t in range(4):
            error += ((decoded[b, t] - actions[b, t]) ** 2).sum().item() / (6 * 4 * 7)
    sigma = log_sigma.exp()
    kl = (0.5 * (sigma**2 + mu**2 - 1) - sigma.log()).sum() / 6
    assert float(loss) == pytest.approx(error + alpha * float(kl), rel=1e-5)
    assert float(info["kl"]) == pytest.approx(float(kl), rel=1e-5)


def test_shapes_and_ranges() -> None:
    vae = SkillVAE(4, 7, 3, 8)
    mu, log_sigma = vae.encode(100 * windows(5))
    assert mu.shape == log_sigma.shape == (5, 3)
    assert log_sigma.min() >= LOG_SIGMA_RANGE[0]
    actions = vae.decode(100 * torch.ones(5, 3))
    assert actions.shape == (5, 4, 7)
    assert actions.abs().max() <= 1.0


def test_reconstruction_error_is_per_action_dimension() -> None:
    vae, actions = SkillVAE(4, 7, 3, 8), windows(5)
    decoded = vae.decode(vae.encode(actions)[0])
    by_hand = [float((decoded[..., i] - actions[..., i]).pow(2).mean().sqrt()) for i in range(7)]
    assert reconstruction_rmse(vae, actions).tolist() == pytest.approx(by_hand)


def test_training_brings_the_loss_down_and_a_seed_fixes_it() -> None:
    """Windows of constant actions: one number per dimension, which three latents can tell."""
    actions = windows(64)[:, :1].expand(-1, 4, -1).contiguous()
    actions[..., 3:] = 0.0
    params = VAEParams(4, 3, 32, alpha=1e-4, steps=300, batch=32, learning_rate=1e-2, augment=0.0)
    trained = train_vae(actions, OSC, params, seed=5)
    untrained = train_vae(actions, OSC, VAEParams(4, 3, 32, steps=0), seed=5)
    before = reconstruction_rmse(untrained, actions)[:3].max()
    assert reconstruction_rmse(trained, actions)[:3].max() < 0.4 * before


@pytest.mark.parametrize("augment", [0.0, 0.5])
def test_the_same_seed_gives_the_same_tensors(augment: float) -> None:
    params = VAEParams(4, 3, 8, steps=10, batch=8, augment=augment)
    first, second = (train_vae(windows(20), OSC, params, seed=3).state_dict() for _ in range(2))
    other = train_vae(windows(20), OSC, params, seed=4).state_dict()
    assert all(torch.equal(first[name], second[name]) for name in first)
    assert not torch.equal(first["output.weight"], other["output.weight"])


def test_the_first_actions_of_a_skill_are_carried_out() -> None:
    z = torch.randn(5, 3)
    whole = SkillVAE(4, 7, 3, 8)
    assert torch.equal(torch.stack(whole.carry_out(z)), whole.decode(z))
    some = SkillVAE(4, 7, 3, 8, execute=2)
    assert torch.equal(torch.stack(some.carry_out(z)), some.decode(z)[:, :2])
    assert some.decode(z).shape == (5, 4, 7)


def test_a_skill_that_opens_a_hand_which_holds_is_carried_out_to_its_end() -> None:
    torch.manual_seed(0)
    vae = SkillVAE(4, 7, 3, 8, execute=2, whole_release=True)
    z, observations = torch.randn(64, 3), torch.zeros(64, ROBOT_STATE.size)
    command = ROBOT_STATE.index("gripper_command")
    observations[:32, command], observations[32:, command] = 1.0, -1.0
    actions = vae.decode(z, observations)
    opens = (actions[..., -1] < 0).any(1)
    assert 0 < int(opens[:32].sum()) < 32
    for row, carried_out in enumerate(vae.carry_out(z, observations)):
        expected = 4 if row < 32 and opens[row] else 2
        assert torch.equal(carried_out, actions[row, :expected])
    with pytest.raises(ValueError, match="give it those too"):
        vae.carry_out(z)


def test_many_windows_are_encoded_some_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    torch.manual_seed(0)
    vae, actions = SkillVAE(4, 7, 3, 16), torch.rand(11, 4, 7) - 0.5
    mu, log_sigma = vae.encode(actions)
    rmse = reconstruction_rmse(vae, actions)
    monkeypatch.setattr("lfr.skills.vae.CHUNK", 4)
    found = vae.encode_all(actions)
    torch.testing.assert_close(found, (mu.detach(), log_sigma.detach()))
    assert not found[0].requires_grad
    torch.testing.assert_close(reconstruction_rmse(vae, actions), rmse)
    assert vae.encode_all(actions[:0])[0].shape == (0, 3)
