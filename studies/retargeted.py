"""A target that is given the source's actions: what learns there fine-tunes the source's policy.

Each action is retargeted as it is carried out (`lfr.mapping.retarget`), for which both arms'
kinematic models must be known.
"""

from __future__ import annotations

import numpy as np

from lfr.embodiments import embodiment
from lfr.mapping.retarget import Retargeting
from lfr.policies import Array
from lfr.sim.kinematics import Kinematics
from lfr.sim.simulation import Simulation
from lfr.sim.steps import Steps


class RetargetedSimulation:
    """An arm in a task, to be stepped with another arm's actions; else as `Simulation`.

    Args:
        source: the embodiment whose actions are given.
    """

    def __init__(self, source: str, target: str, task: str) -> None:
        self._simulation = Simulation(target, task)
        # A model of its own: simulations step side by side.
        self._retargeting = Retargeting(Kinematics(source), embodiment(target))
        self.layout, self.horizon = self._simulation.layout, self._simulation.horizon

    def reset(self, seed: int) -> Array:
        self._retargeting.reset()
        return self._simulation.reset(seed)

    def step(self, actions: Array, stop_on_success: bool = False) -> Steps:
        """As `Simulation.step`, of the source's actions (H, A)."""
        done, observation = [], self._simulation.observation()
        for action in actions:
            here = self._simulation.configuration()
            own = self._retargeting.action(action, observation, here)
            step = self._simulation.step(own[None], stop_on_success)
            done.append(step)
            if step.diverged or (stop_on_success and step.successes.any()):
                break
            observation = step.observations[-1]
        if not done:
            return self._simulation.step(np.empty((0, self._simulation.action_size)))
        return Steps(
            np.concatenate([step.observations for step in done]),
            np.concatenate([step.rewards for step in done]),
            np.concatenate([step.successes for step in done]),
            done[-1].diverged,
        )

    def state(self) -> Array:
        """(S,): the simulation's, and the source's joints (N,) where inverse kinematics began."""
        return np.concatenate([self._simulation.state(), self._retargeting.joints])

    def set_state(self, state: Array) -> None:
        own = len(state) - len(self._retargeting.joints)
        self._simulation.set_state(state[:own])
        self._retargeting.joints = state[own:].copy()
