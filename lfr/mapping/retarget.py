"""Retargeting: what a mapping competes with where both arms' kinematic models are known.

The source's prior chooses a skill and its decoder says the source's actions; the source's model
says what motion of the hand these are, where the hand is, and the target's model which of its own
actions move its hand so. Nothing is learned of the target, and both arms must be calibrated.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lfr.controllers.controller import HAND_UNITS, Configuration
from lfr.embodiments import Embodiment, embodiment
from lfr.policies import Array
from lfr.skills.saved_models import load_prior, load_seen, load_vae
from lfr.skills.skill_policy import SkillPolicy, untranslated
from lfr.spaces import ROBOT_STATE

if TYPE_CHECKING:
    from lfr.sim.kinematics import Kinematics


class Arm(Protocol):
    """The arm that acts, as far as retargeting must know it."""

    def configuration(self) -> Configuration: ...


@dataclass
class RetargetPolicy:
    """A source's policy by skills on another arm, through motions of the hand, step by step.

    Attributes:
        policy: the source's prior and decoder.
        source: the source's kinematic model.
        target: the embodiment that acts.
    """

    policy: SkillPolicy
    source: Kinematics
    target: Embodiment

    def attach(self, arm: Arm) -> None:
        """The arm that acts; before each episode."""
        self._arm = arm

    def reset(self, seed: int) -> None:
        self.policy.reset(seed)
        self._joints, self._ahead = self.source.rest, np.empty((0, self.source.joints + 1))

    def act(self, observation: Array) -> Array:
        """The next action (1, A) for an observation (D,)."""
        if not len(self._ahead):
            self._ahead = self.policy.act(observation)
        action, self._ahead = self._ahead[0], self._ahead[1:]
        motion = np.append(self.motion(action, observation), action[-1])
        return self.target.controller.label(motion, self._arm.configuration())[None]

    def motion(self, action: Array, observation: Array) -> Array:
        """The motion of the hand (6,), in its units, that a source's action (A,) is.

        In the posture in which the source would have its hand where the observation has it.
        """
        if self.source.embodiment.action.names[:3] == ("dx", "dy", "dz"):
            return action[:-1]
        position = observation[ROBOT_STATE.slice("eef_pos")]
        x, y = observation[ROBOT_STATE.slice("eef_rot6d")].reshape(2, 3)
        rotation = np.stack([x, y, np.cross(x, y)], axis=1)
        self._joints = self.source.reach(position, rotation, self._joints)
        there = self.source.at(self._joints)
        return there.jacobian @ (there.scale * action[:-1]) / HAND_UNITS


@dataclass(frozen=True)
class RetargetFiles:
    """The folders of a skill prior and of the skill VAE of its own arm, the source."""

    prior: str
    decoder: str

    def load(self, robot: str) -> RetargetPolicy:
        """Raises DataError where a folder holds no such model, or a damaged one."""
        from lfr.sim.kinematics import kinematics

        source = load_seen(Path(self.decoder)).robot
        policy = SkillPolicy(
            load_prior(Path(self.prior)), untranslated, load_vae(Path(self.decoder))
        )
        return RetargetPolicy(policy, kinematics(source), embodiment(robot))
