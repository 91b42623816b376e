"""Augmented windows are turned, mirrored and scaled: told by what such motions leave as it is."""

import pytest
import torch

from lfr.embodiments import embodiment
from lfr.skills import augmentation
from lfr.skills.augmentation import augment

OSC = embodiment("panda").action.names


@pytest.fixture
def actions() -> torch.Tensor:
    generator = torch.Generator().manual_seed(0)
    return 0.4 * (2 * torch.rand(200, 10, 7, generator=generator) - 1)  # clear of the clipping


def gram(vectors: torch.Tensor, others: torch.Tensor) -> torch.Tensor:
    """(B, H, H) scalar products of (B, H, 3)."""
    return vectors @ others.transpose(1, 2)


def test_an_augmented_window_is_a_scaled_turn_or_mirror_image(actions: torch.Tensor) -> None:
    moved = augment(actions, OSC, torch.Generator().manual_seed(1))
    before, after = actions[..., :3], moved[..., :3]
    ratio = gram(after, after)[:, 0, 0] / gram(before, before)[:, 0, 0]
    low, high = augmentation.SCALE_RANGE
    assert ratio.sqrt().min() >= low - 1e-5
    assert ratio.sqrt().max() <= high + 1e-5
    assert ratio.sqrt().std() > 0.1  # not all alike
    square = ratio[:, None, None]
    torch.testing.assert_close(gram(after, after), square * gram(before, before))
    turns = actions[..., 3:6], moved[..., 3:6]
    torch.testing.assert_close(gram(turns[1], turns[1]), square * gram(turns[0], turns[0]))
    # Rotation vectors are axial: their product with translations changes sign in a mirror.
    products = gram(after, turns[1]) / (square * gram(before, turns[0]))
    sign = products[:, 0, 0].round()
    torch.testing.assert_close(products, sign[:, None, None].expand_as(products), atol=0.05, rtol=0)
    mirrored = (sign == -1).float().mean()
    assert 0.3 < mirrored < 0.7
    torch.testing.assert_close(after[..., 2], ratio.sqrt()[:, None] * before[..., 2])


def test_the_gripper_does_what_it_does_in_another_window(actions: torch.Tensor) -> None:
    """Whole sequences change places; none is lost, and hardly any stays."""
    moved = augment(actions, OSC, torch.Generator().manual_seed(1))
    before, after = actions[..., 6], moved[..., 6]
    same = (after[:, None] == before[None]).all(-1)  # (B, B): whose gripper each window has
    assert same.any(0).all()
    assert same.any(1).all()
    assert same.diagonal().float().mean() < 0.1


def test_joint_motions_are_scaled_and_keep_their_proportions() -> None:
    names = embodiment("sawyer-joint_position").action.names
    generator = torch.Generator().manual_seed(0)
    actions = 0.4 * (2 * torch.rand(50, 10, len(names), generator=generator) - 1)
    ratio = augment(actions, names, generator)[..., :-1] / actions[..., :-1]
    torch.testing.assert_close(ratio, ratio[:, :1, :1].expand_as(ratio))
    assert ratio[:, 0, 0].std() > 0.1


def test_all_directions_occur(actions: torch.Tensor) -> None:
    actions[:, :, :3] = torch.tensor([0.3, 0.0, 0.0])
    moved = augment(actions, OSC, torch.Generator().manual_seed(2))
    angle = torch.atan2(moved[:, 0, 1], moved[:, 0, 0])
    counts = torch.histc(angle, bins=4, min=-torch.pi, max=torch.pi)
    assert counts.min() > 200 / 4 / 2


def test_actions_stay_within_the_controllers_range() -> None:
    moved = augment(torch.ones(50, 10, 7), OSC, torch.Generator().manual_seed(3))
    assert moved.abs().max() <= 1.0
