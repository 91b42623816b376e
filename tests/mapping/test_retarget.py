"""Retargeting: a source's action as a motion of the hand, and as the target's own action."""

from typing import Any

import numpy as np
import pytest
import torch

from lfr.embodiments import embodiment
from lfr.mapping.retarget import RecodedRetargetPolicy, Retargeting, RetargetPolicy
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
    return RetargetPolicy(policy, Retargeting(kinematics(source), embodiment(target)))


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
    policy.retargeting.motion(
        np.zeros(embodiment(source).action.size), observation
    )  # finds the posture
    if source == "panda":
        action = np.append(MOTION, -1.0)
    else:
        action = model.embodiment.controller.label(
            np.append(MOTION, -1.0), model.at(policy.retargeting.joints)
        )
    found = policy.retargeting.motion(action, observation)
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


class Verbatim:
    """A target's skill VAE that can say anything: z is the actions themselves."""

    def encode(self, actions: torch.Tensor, observations: torch.Tensor) -> Any:
        return actions, actions

    def carry_out(self, z: torch.Tensor, observations: torch.Tensor) -> torch.Tensor:
        return z[:, :5]


class Skill(Saying):
    def decode(self, z: torch.Tensor, observations: torch.Tensor) -> torch.Tensor:
        return self.actions


@pytest.mark.parametrize("source", ["panda", "sawyer-joint_position"])
def test_a_skill_foreseen_is_the_skill_step_by_step(source: str) -> None:
    """By the kinematic models alone, where a VAE loses nothing: nearly what the arm itself does."""
    target = "ur5e-joint_position"
    arm, model = simulation(target, "lift"), kinematics(source)
    skill = np.tile(np.append(0.5 * MOTION, -1.0), (10, 1))
    if source != "panda":
        skill = np.tile(np.append(np.linspace(-0.3, 0.3, model.joints), -1.0), (10, 1))
    says: Any = Skill(skill.astype(np.float32))
    verbatim: Any = Verbatim()
    retargeting = Retargeting(model, embodiment(target))
    foreseeing = RecodedRetargetPolicy(
        SkillPolicy(says, untranslated, says), retargeting, kinematics(target), verbatim
    )
    observation = arm.reset(episode_seed("learning", 3))
    foreseeing.attach(arm)
    foreseeing.reset(0)
    foreseen = foreseeing.act(observation)
    assert foreseen.shape == (5, 7)

    stepping = retarget(source, target, skill)
    stepping.attach(arm)
    stepping.reset(0)
    stepped = []
    for _ in range(5):
        stepped.append(stepping.act(observation)[0])
        observation = arm.step(stepped[-1][None]).observations[-1]
    # The first is the same; later ones are of where the arm has come to, which lags behind.
    np.testing.assert_allclose(foreseen[0], stepped[0], atol=1e-6)
    np.testing.assert_allclose(foreseen, np.stack(stepped), atol=0.1)
    assert np.abs(foreseen[:, :-1]).max() > 0.2
