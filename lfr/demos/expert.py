"""The scripted expert: proportional control toward the task's waypoints, noisily executed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lfr.controllers.controller import ROTATION_UNIT, TRANSLATION_UNIT
from lfr.spaces import Space
from lfr.tasks import Task

PERTURBATION_STEPS = 6
PERTURBATION = np.array([0.6, 0.6, 0.6, 0.3, 0.3, 0.3])  # bounds on its components
SLIP_STEPS = 8  # at 0.2 of the gripper's command a step, enough to lose or to miss an object


@dataclass(frozen=True)
class ExpertParams:
    """The demonstrator's manner, which sets the ceiling of all that learns from it.

    Gains are a compromise: weaker ones stall short of a grasp by joint friction, and correct a
    tilted hand by less than a skill VAE resolves; stronger ones turn noise into labels.
    """

    gain: float = 4.0  # hand motion per TRANSLATION_UNIT of distance
    turn_gain: float = 1.0  # hand motion per ROTATION_UNIT of angle
    max_action: float = 1.0  # bound on each component of the clean hand motion
    noise: float = 0.1  # standard deviation of the noise on the executed hand motion
    persistence: float = 0.8  # its correlation from one step to the next
    perturbation: float = 0.01  # chance per step of a push, PERTURBATION_STEPS long
    slip: float = 0.005  # chance per step that the hand does the opposite for SLIP_STEPS steps


class Expert:
    """Acts on one task from the observation alone.

    It thinks in motions of the hand, translation and rotation vector in the base frame, in units of
    `TRANSLATION_UNIT` and `ROTATION_UNIT`; what a controller must be told for one is the
    controller's own business (`Controller.action_of`). ``clean`` is what a learner should do;
    ``execute`` is what the hand is told: the clean motion with Gaussian noise on it, as in DART
    (Laskey et al. 2017), so that demonstrations visit the states around the path and show the way
    back. The noise persists over some steps: it displaces the arm further than white noise would,
    and the clean labels stay smooth. Now and then the arm is pushed centimetres aside, as far as a
    learner's own errors take it, and the hand slips, so that a missed grasp and a lost object have
    been seen and mended.
    """

    def __init__(self, task: Task, layout: Space, params: ExpertParams) -> None:
        self.waypoint = task.waypoint
        self.params = params
        self.disturbance = np.zeros(6)
        self.push, self.pushed = np.zeros(6), 0  # the perturbation, and for how many more steps
        self.slipping = 0
        self.slices = {quantity.name: place for quantity, place in layout.items()}

    def clean(self, observation: np.ndarray) -> np.ndarray:
        """The noiseless hand motion and gripper action (7,) in [-1, 1] for an observation (D,)."""

        def view(quantity: str) -> np.ndarray:
            return observation[self.slices[quantity]]

        waypoint = self.waypoint(view)
        bound = self.params.max_action
        move = self.params.gain * waypoint.delta / TRANSLATION_UNIT
        largest = float(np.abs(move).max())
        if largest > 0.0:  # saturate smoothly and keep the direction: clipping would bend the path
            move = move * (bound * np.tanh(largest / bound) / largest)
        turn = _upright(view("eef_rot6d")) + np.array([0.0, 0.0, waypoint.yaw])
        turn = np.clip(self.params.turn_gain * turn / ROTATION_UNIT, -bound, bound)
        return np.concatenate([move, turn, [waypoint.gripper]])

    def execute(self, clean: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """What the hand is told to do, (7,), where ``clean`` is wanted."""
        noisy = clean.copy()
        rho = self.params.persistence
        fresh = self.params.noise * np.sqrt(1.0 - rho**2) * rng.standard_normal(6)
        self.disturbance = rho * self.disturbance + fresh
        noisy[:6] += self.disturbance
        if self.pushed == 0 and rng.random() < self.params.perturbation:
            self.pushed, self.push = PERTURBATION_STEPS, PERTURBATION * rng.uniform(-1.0, 1.0, 6)
        if self.pushed:
            self.pushed -= 1
            noisy[:6] += self.push
        if self.slipping == 0 and rng.random() < self.params.slip:
            self.slipping = SLIP_STEPS
        if self.slipping:
            self.slipping -= 1
            noisy[6] = -noisy[6]
        return np.clip(noisy, -1.0, 1.0)


def _upright(rot6d: np.ndarray) -> np.ndarray:
    """The rotation vector (3,), base frame, that points the gripper's z axis straight down."""
    approach = np.cross(rot6d[:3], rot6d[3:])
    return np.cross(approach, np.array([0.0, 0.0, -1.0]))
