"""Retargeting: a source's action as a motion of the hand, and as the target's own action."""

from typing import Any

import numpy as np
import pytest
import torch

from lfr.embodiments import embodiment
from lfr.mapping.retarget import RetargetPolicy
from lfr.policies import run_episode
from lfr.seeds import episode_seed
from lfr.sim.kinematics import kinematics
from lfr.sim.simulation import simulation
from lfr.skills.skill_policy import SkillPolicy, untranslated


class Saying:
    """A source that says the same skill whatever it sees; its prior and its decoder."""

    def __init__(self, actions: np.ndarray) -> None:
        self.actions = torch.from_numpy(actions)[None]

    def __call__(self, observation: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        return torch.zeros(1, 2), torch.zeros(1, 2)

    def carry_out(self, z: torch.Tensor, observations: torch.Tensor) -> torch.Tensor:
        return self.actions


def retarget(source: str, target: str, actions: np.ndarray) -> RetargetPolicy:
    says: Any = Saying(actions)
    policy = SkillPolicy(says, untranslated, says)
    return RetargetPolicy(policy, kinematics(source), embodiment(target))


MOTION = np.array([0.2, -0.15, 0.1, 0.02, 0.03, -0.05])


@pytest.mark.parametrize("source", ["panda", "panda-joint_position", "ur5e-joint_position"])
@pytest.mark.parametrize("target", ["sawyer-joint_position", "ur5e-joint_position"])
def test_the_hand_moves_as_the_sources_would(source: str, target: str) -> None:
    """What a source would do for a motion of the hand is that motion of the target's hand."""
    arm, model = simulation(target, "lift"), kinematics(source)
    observation = arm.reset(episode_seed("learning", 3))
    policy = retarget(source, target, np.zeros((5, model.joints + 1)))
    policy.attach(arm)
    policy.reset(0)
    policy.motion(np.zeros(embodiment(source).action.size), observation)  # finds the posture
    if source == "panda":
        action = np.append(MOTION, -1.0)
    else:
        action = model.embodiment.controller.label(
            np.append(MOTION, -1.0), model.at(policy._joints)
        )
    found = policy.motion(action, observation)
    np.testing.assert_allclose(found, MOTION, atol=0.03)


def test_a_skill_is_carried_out_step_by_step() -> None:
    target = "ur5e-joint_position"
    arm = simulation(target, "lift")
    skill = np.tile(np.append(MOTION, -1.0), (5, 1))
    skill[3:, 0] *= -1.0
    policy = retarget("panda", target, skill)
    seen: list[np.ndarray] = []

    class Watched:
        horizon = 10

        def reset(self, seed: int) -> np.ndarray:
            return arm.reset(seed)

        def configuration(self) -> Any:
            return arm.configuration()

        def step(self, actions: np.ndarray, stop_on_success: bool = False) -> Any:
            assert actions.shape == (1, 7)
            wanted = arm.embodiment.controller.label(skill[len(seen) % 5], arm.configuration())
            np.testing.assert_allclose(actions[0], wanted, atol=1e-12)
            seen.append(actions[0])
            return arm.step(actions, stop_on_success)

    run_episode(policy, Watched(), episode_seed("learning", 3))
    assert len(seen) == 10
