"""Retargeting: what a mapping competes with where both arms' kinematic models are known.

The source's prior chooses a skill and its decoder says the source's actions; the source's model
says what motion of the hand these are, where the hand is, and the target's model which of its own
actions move its hand so. Nothing is learned of the target, and both arms must be calibrated.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
import torch

from lfr.controllers.controller import HAND_UNITS, Configuration
from lfr.embodiments import Embodiment, embodiment
from lfr.policies import Array, Policy
from lfr.skills.saved_models import check_actions, load_prior, load_seen, load_vae
from lfr.skills.skill_policy import SkillPolicy, untranslated
from lfr.skills.vae import SkillVAE
from lfr.spaces import ROBOT_STATE

if TYPE_CHECKING:
    from lfr.sim.kinematics import Kinematics


class Arm(Protocol):
    """The arm that acts, as far as retargeting must know it."""

    def configuration(self) -> Configuration: ...


@dataclass
class Retargeting:
    """A source's actions as motions of the hand, and as the target's actions.

    Attributes:
        source: the source's kinematic model.
        target: the embodiment that acts.
        joints: (N,) rad, of the source, with its hand where the target's was last; inverse
            kinematics begins there.
    """

    source: Kinematics
    target: Embodiment

    def __post_init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """An episode begins: the source stands at rest."""
        self.joints = self.source.rest

    def action(self, action: Array, observation: Array, target: Configuration) -> Array:
        """The target's action (A,) for a source's, where an observation (D,) has the hand."""
        motion = np.append(self.motion(action, observation), action[-1])
        return self.target.controller.label(motion, target)

    def motion(self, action: Array, observation: Array) -> Array:
        """The motion of the hand (6,), in its units, that a source's action (A,) is.

        In the posture in which the source would have its hand where the observation has it.
        """
        if not self.by_joints:
            return action[:-1]
        position = observation[ROBOT_STATE.slice("eef_pos")]
        x, y = observation[ROBOT_STATE.slice("eef_rot6d")].reshape(2, 3)
        rotation = np.stack([x, y, np.cross(x, y)], axis=1)
        self.joints = self.source.reach(position, rotation, self.joints)
        return self._moved(action, self.joints)

    def motions(self, actions: Array, observation: Array) -> Array:
        """The motions of the hand (H, 6) that a skill's actions (H, A) are, one after the other."""
        motions = [self.motion(actions[0], observation)]
        joints = self.joints
        for before, action in itertools.pairwise(actions):
            if not self.by_joints:
                motions.append(action[:-1])
                continue
            joints = joints + self.source.at(joints).scale * before[:-1]
            motions.append(self._moved(action, joints))
        return np.stack(motions)

    @property
    def by_joints(self) -> bool:
        """Whether the source's actions are motions of its joints."""
        return self.source.embodiment.action.names[:3] != ("dx", "dy", "dz")

    def _moved(self, action: Array, joints: Array) -> Array:
        there = self.source.at(joints)
        return there.jacobian @ (there.scale * action[:-1]) / HAND_UNITS


@dataclass
class RetargetPolicy:
    """A source's policy on another arm, through motions of the hand, step by step.

    Attributes:
        policy: the source's, by skills.
    """

    policy: Policy
    retargeting: Retargeting

    def attach(self, arm: Arm) -> None:
        """The arm that acts; before each episode."""
        self._arm = arm

    def reset(self, seed: int) -> None:
        self.policy.reset(seed)
        self.retargeting.reset()
        self._ahead: list[Array] = []

    def act(self, observation: Array) -> Array:
        """The next action (1, A) for an observation (D,)."""
        if not self._ahead:
            self._ahead = list(self.policy.act(observation))
        action, self._ahead = self._ahead[0], self._ahead[1:]
        return self.retargeting.action(action, observation, self._arm.configuration())[None]


@dataclass
class RecodedRetargetPolicy:
    """Retargeted skill by skill, and what the target's VAE makes of it: what it can say.

    The target's actions for a whole skill are foreseen by its kinematic model, encoded by its VAE
    and decoded again.

    Attributes:
        policy: the source's prior and decoder.
        model: the target's kinematic model.
        vae: the target's.
    """

    policy: SkillPolicy
    retargeting: Retargeting
    model: Kinematics
    vae: SkillVAE

    def attach(self, arm: Arm) -> None:
        """The arm that acts; before each episode."""
        self._arm = arm

    def reset(self, seed: int) -> None:
        self.policy.reset(seed)
        self.retargeting.reset()

    @torch.inference_mode()
    def act(self, observation: Array) -> Array:
        """The next skill's actions, as many as are carried out, (n, A), for an observation (D,)."""
        seen = torch.as_tensor(observation, dtype=torch.float32)[None]
        mu, _ = self.policy.prior(seen)
        skill = self.policy.decoder.decode(mu, seen)[0].double().numpy()
        motions = np.column_stack([self.retargeting.motions(skill, observation), skill[:, -1]])
        actions, joints = [], self._arm.configuration().joint_position
        for motion in motions:
            there = self.model.at(joints)
            actions.append(self.model.embodiment.controller.label(motion, there))
            joints = joints + there.scale * actions[-1][:-1]
        foreseen = torch.as_tensor(np.stack(actions), dtype=torch.float32)[None]
        z, _ = self.vae.encode(foreseen, seen)
        return self.vae.carry_out(z, seen)[0].double().numpy()


@dataclass(frozen=True)
class RetargetFiles:
    """The folders of a skill prior and of the skill VAE of its own arm, the source.

    Attributes:
        encoder: folder of the target's skill VAE, if what is retargeted is to go through it.
    """

    prior: str
    decoder: str
    encoder: str | None = None

    def load(self, robot: str) -> RetargetPolicy | RecodedRetargetPolicy:
        """Raises DataError where a folder holds no such model, a damaged one or other actions."""
        from lfr.sim.kinematics import kinematics

        prior, decoder = Path(self.prior), Path(self.decoder)
        policy = SkillPolicy(load_prior(prior), untranslated, load_vae(decoder))
        retargeting = Retargeting(kinematics(load_seen(decoder).robot), embodiment(robot))
        if self.encoder is None:
            return RetargetPolicy(policy, retargeting)
        check_actions(Path(self.encoder), robot)
        vae = load_vae(Path(self.encoder))
        return RecodedRetargetPolicy(policy, retargeting, kinematics(robot), vae)
