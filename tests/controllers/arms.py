"""An arm in motion, and its dynamics as MuJoCo gives them."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from lfr.sim.simulation import Simulation, simulation


def moving(name: str) -> Simulation:
    """An embodiment in `lift`, its hand on the way up and its kinematics fresh."""
    engine = simulation(name, "lift")
    engine.reset(1)
    rng = np.random.default_rng(2)
    for _ in range(6):
        motion = rng.uniform(-1, 1, 6) * [1, 1, 0, 1, 1, 1]
        move = engine.embodiment.controller.action_of(motion, engine.configuration())
        engine.step(np.append(move, rng.choice([-1.0, 1.0])))
    mujoco.mj_step1(engine._model, engine._data)
    return engine


@dataclass(frozen=True)
class Dynamics:
    """Of an arm with N joints: J (6, N) of the grip site, M (N, N), bias, q, q_dot, limits."""

    jacobian: NDArray[np.float64]
    mass: NDArray[np.float64]
    bias: NDArray[np.float64]
    q: NDArray[np.float64]
    dq: NDArray[np.float64]
    limits: NDArray[np.float64]

    @classmethod
    def of(cls, engine: Simulation) -> Dynamics:
        model, data, n = engine._model, engine._data, engine.joints
        jacobian = np.zeros((6, model.nv))
        site = engine._scene.arrays.grip_site
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, full, data.qM)
        return cls(
            jacobian[:, :n], full[:n, :n], data.qfrc_bias[:n].copy(), data.qpos[:n].copy(),
            data.qvel[:n].copy(), model.actuator_ctrlrange[:n],
        )  # fmt: skip

    def clipped(self, torque: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip(torque, self.limits[:, 0], self.limits[:, 1])
