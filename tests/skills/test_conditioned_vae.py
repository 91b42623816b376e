"""The skill VAE that sees the hand's pose, and an error that counts at the hand."""

from pathlib import Path

import pytest
import torch

from lfr.embodiments import embodiment
from lfr.skills.condition import GIVEN_NOTHING, POSE_NAMES, Condition
from lfr.skills.hand_motion import HandJacobian
from lfr.skills.saved_models import Seen, load_vae, save_vae
from lfr.skills.skill_params import VAEParams
from lfr.skills.skill_training import train_vae
from lfr.skills.symmetry import SceneMotion, move
from lfr.skills.vae import SkillVAE, action_error, reconstruction_rmse, vae_loss

JOINTS = embodiment("panda-joint_position").action.names
SEES = Condition(POSE_NAMES, turned=True)
SEEN = Seen("panda-joint_position", ("lift",), {}, 0)


def poses(count: int, seed: int = 0) -> torch.Tensor:
    """Hands in front of the base, turned about the vertical."""
    generator = torch.Generator().manual_seed(seed)
    place = torch.rand(count, 3, generator=generator) * 0.4 + torch.tensor([0.3, -0.2, 0.0])
    angle = torch.rand(count, generator=generator)
    cos, sin, zero = torch.cos(angle), torch.sin(angle), torch.zeros(count)
    return torch.cat([place, torch.stack([cos, sin, zero, sin, -cos, zero], dim=-1)], dim=-1)


def windows(count: int, seed: int = 1) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(count, 4, len(JOINTS), generator=generator) * 2 - 1


def conditioned() -> SkillVAE:
    torch.manual_seed(0)
    vae = SkillVAE(4, len(JOINTS), 3, 8, 2, *SEES)
    assert vae.normalizer is not None
    vae.normalizer.fit(poses(50), POSE_NAMES)
    return vae.eval()


def test_it_needs_the_observation_and_saves_what_it_sees(tmp_path: Path) -> None:
    vae, z = conditioned(), torch.randn(5, 3)
    with pytest.raises(ValueError, match="sees the state"):
        vae.decode(z)
    assert not torch.allclose(vae.decode(z, poses(5)), vae.decode(z, poses(5, 7)))
    save_vae(tmp_path, vae, SEEN)
    again = torch.stack(load_vae(tmp_path).carry_out(z, poses(5)))
    assert torch.equal(again, torch.stack(vae.carry_out(z, poses(5))))


@pytest.mark.parametrize(
    ("names", "condition", "whole"),
    [(JOINTS, SEES, True), (JOINTS, GIVEN_NOTHING, False), ((*JOINTS[:-1], "j"), SEES, False)],
    ids=["a hand in sight", "sees nothing", "no hand"],
)
def test_only_who_sees_a_hand_waits_for_it(
    names: tuple[str, ...], condition: Condition, whole: bool
) -> None:
    params = VAEParams(4, 2, whole_release=True, latent_dim=3, hidden=8, steps=0)
    found = train_vae(
        torch.rand(20, 4, len(JOINTS)), names, params, seed=0, states=poses(20), condition=condition
    )
    assert found.whole_release == whole


def test_a_turned_scene_is_the_same_skill() -> None:
    vae, seen, actions = conditioned(), poses(5), windows(5)
    angle = torch.full((5,), 0.7)
    turned = move(seen, POSE_NAMES, SceneMotion(angle, torch.ones(5), torch.zeros(5, 3), True))
    assert not torch.allclose(seen, turned, atol=0.01)
    z = vae.encode(actions, seen)[0]
    torch.testing.assert_close(vae.encode(actions, turned)[0], z)
    torch.testing.assert_close(vae.decode(z, turned), vae.decode(z, seen))


def test_many_windows_are_encoded_each_at_its_own_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    vae, seen, actions = conditioned(), poses(11), windows(11)
    whole, rmse = vae.encode(actions, seen), reconstruction_rmse(vae, actions, seen)
    monkeypatch.setattr("lfr.skills.vae.CHUNK", 4)
    for found, expected in zip(vae.encode_all(actions, seen), whole, strict=True):
        torch.testing.assert_close(found, expected)
    torch.testing.assert_close(reconstruction_rmse(vae, actions, seen), rmse)


def test_what_the_pose_says_needs_no_latent() -> None:
    """Actions that follow from the pose alone, and a latent space that may say next to nothing."""
    seen = poses(400)
    actions = torch.sin(12 * seen[:, None, :1]).expand(-1, 4, len(JOINTS)).contiguous()
    seen = seen.clone()
    seen[:, 1] = 0.0  # the azimuth, which it does not see
    params = VAEParams(4, 4, 2, hidden=16, alpha=10.0, steps=300, batch=32, augment=0.0)
    blind = train_vae(actions, JOINTS, params, 3)
    sees = train_vae(actions, JOINTS, params, 3, states=seen, condition=SEES)
    errors = [reconstruction_rmse(vae, actions, seen).mean() for vae in (sees, blind)]
    assert errors[0] < 0.3 * errors[1]


def test_an_error_at_the_hand_by_hand() -> None:
    error, J = windows(5), torch.randn(5, 6, 7)
    expected = 0.0
    for b in range(5):
        for t in range(4):
            joints, gripper = error[b, t, :7], error[b, t, 7]
            hand = sum(float(J[b, i] @ joints) ** 2 for i in range(6))
            expected += hand + 0.3 * float(joints @ joints) + float(gripper) ** 2
    assert float(action_error(error, J)) == pytest.approx(expected / (5 * 4 * 8), rel=1e-5)
    assert float(action_error(error)) == pytest.approx(float(error.square().mean()))


def test_training_spends_its_latents_on_what_moves_the_hand() -> None:
    """Two joints of equal motion, of which only the first moves the hand; one latent for both."""
    actions = torch.zeros(400, 4, len(JOINTS))
    actions[..., :2] = windows(400)[:, :1, :2]
    jacobian = HandJacobian(7, 4).eval()
    for layer in (jacobian.network[0], jacobian.network[2], jacobian.network[4]):
        torch.nn.init.zeros_(layer.weight)  # type: ignore[arg-type]
        torch.nn.init.zeros_(layer.bias)  # type: ignore[arg-type]
    jacobian.network[4].bias.data[:1] = 3.0  # type: ignore[union-attr]  # x by the first joint
    params = VAEParams(4, 4, 1, hidden=16, alpha=1e-4, steps=400, batch=32, augment=0.0)
    seen = poses(400)
    vae = train_vae(actions, JOINTS, params, 3, states=seen, condition=SEES, jacobian=jacobian)
    first, second = reconstruction_rmse(vae, actions, seen)[:2]
    assert first < 0.4 * second


def test_the_loss_is_that_of_its_parts() -> None:
    vae, actions, seen, J = conditioned(), windows(6), poses(6), torch.randn(6, 6, 7)
    torch.manual_seed(1)
    loss, info = vae_loss(vae, actions, 0.25, vae.features(seen), J)
    mu, log_sigma = vae.encode(actions, seen)
    torch.manual_seed(1)
    z = mu + log_sigma.exp() * torch.randn(mu.shape)
    error = action_error(vae.reconstruct(z, seen) - actions, J)
    assert float(loss) == pytest.approx(float(error + 0.25 * info["kl"]), rel=1e-5)
