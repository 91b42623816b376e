"""Starts: their distribution against stock's own samplers."""

import numpy as np
import pytest
from scipy.stats import ks_2samp

from lfr.sim.simulation import Simulation, simulation
from lfr.tasks import TASKS
from tests.sim.pairs import stock


def pose_after_reset(engine: Simulation, seed: int, address: int) -> np.ndarray:
    engine.reset(seed)
    return engine.position()[address : address + 7]


@pytest.mark.parametrize(("robot", "task"), [("sawyer", task) for task in TASKS])
def test_object_places_are_distributed_as_stock_samples_them(robot: str, task: str) -> None:
    engine, environment = simulation(robot, task), stock(robot, task)._env
    joint = f"{next(iter(engine.task.objects.values())).removesuffix('_main')}_joint0"
    address = engine._model.joint(joint).qposadr[0]
    ours = np.array([pose_after_reset(engine, seed, address) for seed in range(300)])
    theirs = []
    for _ in range(300):
        samples = environment.placement_initializer.sample().values()
        theirs += [[*p, *q] for p, q, item in samples if item.joints and item.joints[0] == joint]
    for column in (0, 1, 6):
        assert ks_2samp(ours[:, column], np.array(theirs)[:, column]).pvalue > 1e-4
    if task != "lift":  # there the height follows the size of each episode's cube
        assert ours[0, 2] == pytest.approx(theirs[0][2])


def test_joint_noise_and_cube_sizes_have_stocks_spread() -> None:
    engine = simulation("panda", "lift")
    start, joints, found = engine._scene.start, [], []
    for seed in range(400):
        engine.reset(seed)
        joints.append(engine.joint_position())
        found.append(engine.cube_size())
    assert (np.array(joints) - start.joint_position).std() == pytest.approx(0.02, rel=0.05)
    sizes = np.array(found)
    assert 0.020 <= sizes.min() < 0.0202
    assert 0.0218 < sizes.max() <= 0.022
    assert np.corrcoef(sizes[:, 0], sizes[:, 2])[0, 1] == pytest.approx(0, abs=0.15)
