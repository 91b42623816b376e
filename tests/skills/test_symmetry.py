"""A moved scene, held to the expert, which knows nothing of it, and to its own sums."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lfr.demos.expert import Expert, ExpertParams
from lfr.embodiments import embodiment
from lfr.errors import LfrError
from lfr.skills.rows import MOST_ROWS, thinned
from lfr.skills.symmetry import (
    SceneMotion,
    SymmetryParams,
    move,
    move_actions,
    moved_copies,
    moved_states,
    suited,
)
from lfr.spaces import Space, gripper_action, joint_motion
from lfr.tasks import TASKS

OSC = embodiment("panda").action.names
angles = st.floats(-math.pi, math.pi)
mirrors = st.sampled_from([-1.0, 1.0])
shifts = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
rotations = st.tuples(*[st.floats(-0.3, 0.3)] * 2, st.floats(-math.pi, math.pi))


def motion(angle: float, mirror: float, shift: tuple[float, float]) -> SceneMotion:
    return SceneMotion(
        torch.tensor([angle], dtype=torch.float64),
        torch.tensor([mirror], dtype=torch.float64),
        torch.tensor([[*shift, 0.0]], dtype=torch.float64),
    )


def lift_observation(rotation: tuple[float, float, float], to_cube: np.ndarray) -> torch.Tensor:
    """Lift, the hand near straight down and turned, the cube beside it and turned."""
    layout = TASKS["lift"].observation
    x, y, z = rotation
    spin = np.array([[math.cos(z), -math.sin(z), 0], [math.sin(z), math.cos(z), 0], [0, 0, 1]])
    roll = np.array([[1, 0, 0], [0, math.cos(x), -math.sin(x)], [0, math.sin(x), math.cos(x)]])
    pitch = np.array([[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]])
    hand = spin @ pitch @ roll @ np.diag([1.0, -1.0, -1.0])
    observation = np.zeros(layout.size)
    values = {
        "eef_pos": np.array([0.5, 0.1, 0.1]),
        "eef_rot6d": np.concatenate([hand[:, 0], hand[:, 1]]),
        "gripper_aperture": [0.05],
        "gripper_command": [-1.0],
        "cube_pos": np.array([0.5, 0.1, 0.1]) + to_cube,
        "cube_up": [0.0, 0.0, 1.0],
        "eef_to_cube": to_cube,
        "cube_yaw": [math.cos(0.4), math.sin(0.4)],
    }
    for group, value in values.items():
        observation[layout.slice(group)] = value
    return torch.tensor(observation)[None]


@settings(max_examples=50)
@given(angle=angles, mirror=mirrors, shift=shifts, rotation=rotations)
def test_the_expert_in_a_moved_scene_does_the_moved_action(
    angle: float, mirror: float, shift: tuple[float, float], rotation: tuple[float, float, float]
) -> None:
    layout = TASKS["lift"].observation
    # So weak that no component saturates: the bound is on components, not on the length.
    expert = Expert(TASKS["lift"], layout, ExpertParams(gain=1e-3, turn_gain=0.05))
    seen = lift_observation(rotation, np.array([0.05, -0.02, -0.1]))
    action = torch.tensor(expert.clean(seen[0].numpy()))
    moved = motion(angle, mirror, shift)
    there = expert.clean(move(seen, layout.names, moved)[0].numpy())
    expected = move_actions(action[None, None], OSC, moved)[0, 0].numpy()
    np.testing.assert_allclose(there, expected, atol=1e-6)


@settings(max_examples=30)
@given(angle=angles, mirror=mirrors, shift=shifts, rotation=rotations)
def test_a_moved_observation_is_still_one(
    angle: float, mirror: float, shift: tuple[float, float], rotation: tuple[float, float, float]
) -> None:
    layout = TASKS["lift"].observation
    seen = lift_observation(rotation, np.array([0.05, -0.02, -0.1]))
    moved = move(seen, layout.names, motion(angle, mirror, shift))[0].numpy()

    def part(group: str) -> np.ndarray:
        return moved[layout.slice(group)]

    np.testing.assert_allclose(part("cube_pos") - part("eef_pos"), part("eef_to_cube"), atol=1e-12)
    x, y = part("eef_rot6d")[:3], part("eef_rot6d")[3:]
    np.testing.assert_allclose([x @ x, y @ y, x @ y], [1.0, 1.0, 0.0], atol=1e-12)
    approach = seen[0].numpy()[layout.slice("eef_rot6d")]
    before = np.cross(approach[:3], approach[3:])
    assert np.cross(x, y)[2] == pytest.approx(before[2])  # the hand still points down


@pytest.mark.parametrize("task", TASKS)
def test_every_task_can_be_moved(task: str) -> None:
    names = TASKS[task].observation.names
    observations, actions = torch.randn(5, len(names)), torch.rand(5, 10, 7) - 0.5
    generator = torch.Generator().manual_seed(0)
    params = SymmetryParams(copies=2)
    seen, done = moved_copies(observations, actions, names, OSC, params, generator)
    assert seen.shape == (15, len(names))
    assert done.shape == (15, 10, 7)
    torch.testing.assert_close(seen[:5], observations)
    lengths = done[..., :3].norm(dim=-1)
    torch.testing.assert_close(lengths[5:10], lengths[:5])  # turned, not scaled
    assert not torch.allclose(seen[5:10], observations)


def test_no_copies_are_the_demonstrations_themselves() -> None:
    names = TASKS["stack"].observation.names
    observations, actions = torch.randn(4, len(names)), torch.randn(4, 10, 7)
    params = SymmetryParams(copies=0)
    seen, done = moved_copies(observations, actions, names, OSC, params, torch.Generator())
    assert seen is observations
    assert done is actions


def joint_actions(joints: int) -> tuple[torch.Tensor, tuple[str, ...]]:
    """Windows (4, 10, A) of an arm of so many joints, and the names of their dimensions."""
    motions = joint_motion([f"joint{number}" for number in range(joints)])
    names = Space((motions, gripper_action())).names
    return torch.rand(4, 10, len(names)) - 0.5, names


@pytest.mark.parametrize("joints", [5, 6, 7, 14])
def test_joint_motions_are_the_same_in_a_turned_scene_and_unknown_in_another(joints: int) -> None:
    actions, names = joint_actions(joints)
    turn = SymmetryParams(copies=1, mirror=False, shift=0.0)
    turned = SceneMotion.draw(len(actions), turn, torch.Generator().manual_seed(0))
    assert torch.equal(move_actions(actions, names, turned), actions)
    for further in (SymmetryParams(mirror=True, shift=0.0), SymmetryParams(mirror=False)):
        motion = SceneMotion.draw(len(actions), further, torch.Generator().manual_seed(0))
        with pytest.raises(LfrError, match="'dq' moves with the scene is not known"):
            move_actions(actions, names, motion)


def test_what_is_asked_for_is_cut_down_to_what_is_known_of_the_action() -> None:
    asked, (_, joints) = SymmetryParams(), joint_actions(6)
    assert suited(asked, OSC) == asked
    assert suited(asked, joints).copies == 0  # a prior sees them in the frame of the azimuth
    assert suited(asked, ("number.left", "gripper")).copies == 0


def test_an_unknown_quantity_is_refused() -> None:
    with pytest.raises(LfrError, match="wrist_torque"):
        move(torch.zeros(1, 1), ["wrist_torque.x"], motion(0.1, 1.0, (0.0, 0.0)))


@given(rows=st.integers(1, 2 * MOST_ROWS), copies=st.integers(0, 40))
def test_copies_end_where_memory_would(rows: int, copies: int) -> None:
    made = SymmetryParams(copies=copies).copies_of(rows)
    assert 0 <= made <= copies
    assert made == 0 or rows * (made + 1) <= MOST_ROWS
    assert made == copies or rows * (made + 2) > MOST_ROWS  # not fewer than there is room for


@given(rows=st.integers(0, 3 * MOST_ROWS))
def test_few_rows_are_all_kept_and_many_are_thinned_evenly(rows: int) -> None:
    kept = thinned(torch.arange(rows))
    assert len(kept) <= MOST_ROWS
    assert len(kept) == rows or len(kept) > MOST_ROWS // 2
    assert rows < 2 or len(kept.diff().unique()) == 1


def test_states_of_unknown_quantities_are_left_alone_without_copies() -> None:
    names, states = ["joint_1.pos", "joint_2.pos"], torch.ones(3, 2)
    generator = torch.Generator().manual_seed(0)
    assert moved_states(states, names, SymmetryParams(copies=0), generator) is states
    with pytest.raises(LfrError, match="joint_1"):
        moved_states(states, names, SymmetryParams(copies=1), generator)
