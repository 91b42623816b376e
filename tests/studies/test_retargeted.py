"""A simulation that takes another arm's actions, against the policy that retargets them itself."""

from __future__ import annotations

import numpy as np
import pytest

from lfr.embodiments import embodiment
from lfr.mapping.retarget import Retargeting, RetargetPolicy
from lfr.policies import run_episode
from lfr.seeds import episode_seed
from lfr.sim.kinematics import kinematics
from lfr.sim.simulation import Simulation
from studies.retargeted import RetargetedSimulation

SOURCE, TARGET, TASK = "sawyer-joint_position", "ur5e-joint_position", "lift"


class Wandering:
    """Source's actions drawn anew for each skill of five steps."""

    def reset(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)

    def act(self, observation: np.ndarray) -> np.ndarray:
        return self._random.uniform(-0.4, 0.4, (5, 8))


class Noted:
    """Keeps what a simulation shows after each skill."""

    def __init__(self, simulation) -> None:
        self._simulation, self.seen, self.horizon = simulation, [], 40

    def reset(self, seed: int) -> np.ndarray:
        return self._simulation.reset(seed)

    def configuration(self):
        return self._simulation.configuration()

    def step(self, actions: np.ndarray, stop_on_success: bool = False):
        steps = self._simulation.step(actions, stop_on_success)
        self.seen.extend(steps.observations)
        return steps


def test_it_does_what_the_retargeting_policy_does() -> None:
    seed = episode_seed("learning", 7)
    inside = Noted(RetargetedSimulation(SOURCE, TARGET, TASK))
    run_episode(Wandering(), inside, seed)
    outside = Noted(Simulation(TARGET, TASK))
    retargeting = Retargeting(kinematics(SOURCE), embodiment(TARGET))
    run_episode(RetargetPolicy(Wandering(), retargeting), outside, seed)
    assert len(inside.seen) == len(outside.seen) == 40
    np.testing.assert_array_equal(inside.seen, outside.seen)


@pytest.mark.parametrize("steps", [1, 5])
def test_it_goes_on_from_a_state(steps: int) -> None:
    simulation, other = (RetargetedSimulation(SOURCE, TARGET, TASK) for _ in range(2))
    seed = episode_seed("learning", 8)
    actions = np.random.default_rng(0).uniform(-0.4, 0.4, (10 + steps, 8))
    simulation.reset(seed)
    simulation.step(actions[:10])
    state = simulation.state()
    other.reset(seed)
    other.set_state(state)
    found, again = (one.step(actions[10:]) for one in (simulation, other))
    np.testing.assert_allclose(found.observations, again.observations, atol=1e-9)
    assert len(found) == steps
    assert len(simulation.step(actions[:0])) == 0
