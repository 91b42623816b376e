"""What transfer learning needs of a simulation, and one episode that runs in it skill by skill."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

from lfr.policies import Array, Simulated
from lfr.sim.steps import Steps


class Resumable(Simulated, Protocol):
    """A simulation that can go on from a state that it was in."""

    def state(self) -> Array: ...
    def set_state(self, state: Array, /) -> None: ...


@dataclass(frozen=True)
class RewardRule:
    """What a skill earns, and whether success ends the episode.

    Attributes:
        kind: "sparse": 1 for the skill in which the task succeeds, which is terminal. "dense":
            robosuite's shaped reward summed over the executed control steps, up to the horizon.
        dense_scale: factor on the dense reward.
        until_success: end a dense episode at success too, where only its success is asked for.
    """

    kind: Literal["sparse", "dense"]
    dense_scale: float
    until_success: bool = False

    @property
    def stop_on_success(self) -> bool:
        return self.kind == "sparse" or self.until_success

    def reward(self, steps: Steps) -> float:
        if self.kind == "sparse":
            return float(steps.successes.any())
        return float(steps.rewards.sum()) * self.dense_scale


class Outcome(NamedTuple):
    """What one skill did."""

    steps: int  # control steps executed, 1..H
    reward: float
    observation: Array  # (D,) after it
    terminated: bool  # a terminal state: nothing is earned after it
    over: bool  # the episode ended: terminal, time limit or diverged
    valid: bool  # False if the simulation diverged: not to be learned from


@dataclass
class RunningEpisode:
    """An episode between two skills; ``start`` begins the next one in the same simulation."""

    simulation: Resumable
    seed: int = 0
    observation: Array = None  # type: ignore[assignment]  # set by start or restore
    length: int = 0  # control steps so far
    total: float = 0.0  # sum of the skills' rewards
    success: bool = False  # reached at any step so far

    def start(self, seed: int) -> None:
        self.seed, self.length, self.total, self.success = seed, 0, 0.0, False
        self.observation = self.simulation.reset(seed)

    def execute(self, actions: Array, rule: RewardRule) -> Outcome:
        """Execute a skill's actions (H, A), cut at the time limit."""
        left = self.simulation.horizon - self.length
        steps = self.simulation.step(actions[:left], stop_on_success=rule.stop_on_success)
        count = len(steps.rewards)
        self.length += count
        if steps.diverged or count == 0:
            return Outcome(count, 0.0, self.observation, False, True, False)
        reward = rule.reward(steps)
        self.total += reward
        self.success = self.success or bool(steps.successes.any())
        self.observation = steps.observations[-1]
        terminated = rule.stop_on_success and self.success
        over = terminated or self.length >= self.simulation.horizon
        return Outcome(count, reward, self.observation, terminated, over, True)

    def suspend(self) -> tuple[Array, Array, list[float]]:
        """The simulation's state, the observation and the counts: all that ``restore`` needs."""
        counts = [self.seed, self.length, self.total, self.success]
        return self.simulation.state().copy(), self.observation.copy(), [float(c) for c in counts]

    def restore(self, state: Array, observation: Array, counts: list[float]) -> None:
        """Continue exactly from where ``suspend`` was called."""
        self.seed, self.length = int(counts[0]), int(counts[1])
        self.total, self.success = counts[2], bool(counts[3])
        self.simulation.reset(self.seed)  # what differs by seed and is no state, such as sizes
        self.simulation.set_state(state)
        self.observation = observation.copy()
