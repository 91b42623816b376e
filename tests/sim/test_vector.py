"""Batches of environments: against single ones, and against Gymnasium's own vector environment."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import lfr.sim.environment  # noqa: F401  (registers the environments)
from lfr.errors import UnknownNameError
from lfr.sim.batch import Batch
from lfr.sim.simulation import simulation


def test_a_batch_on_threads_equals_simulations_one_after_the_other() -> None:
    actions = np.random.default_rng(0).uniform(-1, 1, (5, 8, 7))
    seeds = np.arange(5)
    with Batch("panda", "stack", 5, threads=3) as batch:
        starts = batch.reset(seeds)
        found = batch.step(actions)
    engine = simulation("panda", "stack")
    for i, steps in enumerate(found):
        np.testing.assert_array_equal(engine.reset(int(seeds[i])), starts[i])
        alone = engine.step(actions[i])
        np.testing.assert_array_equal(alone.observations, steps.observations)
        np.testing.assert_array_equal(alone.rewards, steps.rewards)


def test_one_that_diverges_does_not_stop_the_others() -> None:
    actions = np.zeros((3, 4, 7))
    actions[1, 2, 0] = np.nan
    with Batch("panda", "lift", 3, threads=2) as batch:
        batch.reset([0, 1, 2])
        found = batch.step(actions)
    assert [steps.diverged for steps in found] == [False, True, False]
    assert [len(steps) for steps in found] == [4, 3, 4]


def test_it_is_gymnasiums_sync_vector_env_but_faster() -> None:
    """Seeds, time limits, infos and automatic resets, over several episodes."""
    limit = 6
    name = "lfr/Lift-Panda-v0"
    ours = gymnasium.make_vec(name, num_envs=3, threads=2, max_episode_steps=limit)
    single = [lambda: gymnasium.make(name, max_episode_steps=limit) for _ in range(3)]
    theirs = SyncVectorEnv(single)
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    assert ours.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert ours.action_space == theirs.action_space
    assert ours.observation_space == theirs.observation_space
    equal(ours.reset(seed=4), theirs.reset(seed=4))
    actions = np.random.default_rng(1).uniform(-1, 1, (15, 3, 7)).astype(np.float32)
    actions[3, 1] = np.nan  # this one diverges, and begins again by itself
    ends = 0
    for action in actions:
        mine, gymnasiums = ours.step(action), theirs.step(action)
        equal(mine, gymnasiums)
        ends += int((mine[2] | mine[3]).sum())
    assert ends > 3
    mask = np.array([False, True, False])
    options = {"reset_mask": mask}
    equal(ours.reset(seed=7, options=dict(options)), theirs.reset(seed=7, options=dict(options)))
    ours.close()


def equal(mine: tuple, theirs: tuple) -> None:
    for one, other in zip(mine[:-1], theirs[:-1], strict=True):
        np.testing.assert_array_equal(one, other)
    assert mine[-1].keys() == theirs[-1].keys()
    for key in mine[-1]:
        np.testing.assert_array_equal(mine[-1][key], theirs[-1][key])


def test_each_ones_picture_is_that_of_a_single_environment() -> None:
    name = "lfr/Stack-UR5e-v0"
    ours = gymnasium.make_vec(name, num_envs=2, render_mode="rgb_array")
    ours.reset(seed=4)
    pictures = ours.render()
    assert pictures is not None
    for seed, picture in zip((4, 5), pictures, strict=True):
        single = gymnasium.make(name, render_mode="rgb_array")
        single.reset(seed=seed)
        np.testing.assert_array_equal(picture, single.render())
        single.close()
    assert (pictures[0] != pictures[1]).any()
    ours.close()
    assert gymnasium.make_vec(name, num_envs=1).render() is None
    with pytest.raises(UnknownNameError, match="'human'; valid: rgb_array"):
        gymnasium.make_vec(name, num_envs=1, render_mode="human")


def test_wrong_shapes_and_names_are_refused() -> None:
    environments = gymnasium.make_vec("lfr/Lift-Panda-v0", num_envs=2)
    environments.reset(seed=0)
    with pytest.raises(ValueError, match=r"\(3, 7\), expected \(2, 7\)"):
        environments.step(np.zeros((3, 7)))
    with pytest.raises(ValueError, match="3 seeds for 2"):
        environments.reset(seed=[1, 2, 3])
    environments.close()
    with pytest.raises(UnknownNameError, match="dense, sparse"):
        gymnasium.make_vec("lfr/Lift-Panda-v0", num_envs=2, reward="shaped")
    with pytest.raises(ValueError, match="at least one"):
        Batch("panda", "lift", 0)
