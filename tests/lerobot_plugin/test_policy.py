"""An exported policy, loaded by LeRobot's own factories, does what the saved one does."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.policies import make_policy, make_pre_post_processors
from safetensors.torch import load_file, save_file

from lfr.errors import DataError, LfrError, ParameterError
from lfr.lerobot_plugin.configuration_lfr import LfrConfig
from lfr.lerobot_plugin.env_config import LfrEnv
from lfr.lerobot_plugin.export import export_policy
from lfr.lerobot_plugin.modeling_lfr import LfrPolicy
from lfr.skills.vae import SkillVAE
from lfr.transfer.model import load_policy

SIZE = (11, 11)  # of Lift's state and environment state


def loaded(folder: Path, env: LfrEnv | None = None) -> tuple[Any, Any, Any]:
    """Policy and processors as `lerobot-eval --policy.path` makes them."""
    config = PreTrainedConfig.from_pretrained(folder)
    config.pretrained_path = folder
    policy = make_policy(config, env_cfg=env or LfrEnv(robot="panda", task="lift"))
    return policy, *make_pre_post_processors(config, str(folder))


def batch_of(observations: np.ndarray) -> dict[str, torch.Tensor]:
    rows = torch.from_numpy(observations).float()
    return {"observation.state": rows[:, :11], "observation.environment_state": rows[:, 11:]}


def test_it_carries_out_the_same_skills(saved: Path, exported: Path) -> None:
    actor, _ = load_policy(saved)
    policy, before, after = loaded(exported)
    policy.reset()
    rng = np.random.default_rng(0)
    for _ in range(2):  # skills
        observations = rng.normal(size=(3, sum(SIZE)))
        expected = np.stack(actor.act_all(observations))  # (B, n, A)
        assert expected.shape == (3, 5, 7)
        for step in range(5):
            if step:  # what is observed within a skill changes nothing
                observations = rng.normal(size=observations.shape)
            action = after(policy.select_action(before(batch_of(observations))))
            np.testing.assert_array_equal(action.numpy(), expected[:, step])


def test_a_new_episode_begins_with_a_new_skill(saved: Path, exported: Path) -> None:
    actor, _ = load_policy(saved)
    policy, _, _ = loaded(exported)
    policy.reset()
    first, second = np.random.default_rng(1).normal(size=(2, 1, sum(SIZE)))
    policy.select_action(batch_of(first))
    policy.reset()
    action = policy.select_action(batch_of(second))
    np.testing.assert_array_equal(action.numpy(), actor.act_all(second)[0][None, 0])


def test_where_an_arm_is_resampled_each_action_is_repeated(saved: Path, exported: Path) -> None:
    actor, _ = load_policy(saved)
    policy, _, _ = loaded(exported)
    policy._ratio = 2.5  # control steps to an action: 3, 2, 3, 2, ...
    observations = np.random.default_rng(3).normal(size=(25, 2, sum(SIZE)))
    found = [policy.select_action(batch_of(seen)).numpy() for seen in observations]
    skills = [np.stack(actor.act_all(observations[begin])) for begin in (0, 13)]  # (B, 5, A)
    lasts = [3, 2, 3, 2, 3, 2, 3, 2, 3, 2]
    expected = np.repeat(np.concatenate(skills, axis=1), lasts, axis=1)
    np.testing.assert_array_equal(np.stack(found, axis=1), expected)
    chunk = policy.predict_action_chunk(batch_of(observations[0]))
    np.testing.assert_array_equal(chunk.numpy(), expected[:, :13])


def test_each_row_carries_out_its_own_skills(exported: Path) -> None:
    """Whose hand lets go goes on to the end of its skill, whatever the others do."""
    observations = np.random.default_rng(2).normal(size=(12, 8, sum(SIZE)))
    together, _, _ = loaded(exported)
    alone = [loaded(exported)[0] for _ in range(8)]
    for policy in (together, *alone):
        decoder, seen = policy._actor.decoder, torch.from_numpy(observations[0]).float()
        assert isinstance(decoder, SkillVAE)
        decoder.whole_release = True
        with torch.no_grad():  # so that half of the skills open the hand
            gripper = decoder.reconstruct(policy._actor.choose(seen).z, seen)[..., -1]
            decoder.output.bias[-1] -= gripper.amin(1).median()
    expected = np.stack([
        [policy.select_action(batch_of(seen[row : row + 1]))[0].numpy() for seen in observations]
        for row, policy in enumerate(alone)
    ])  # fmt: skip
    lengths = {tuple(map(len, policy._waiting)) for policy in alone}
    assert len(lengths) > 1
    found = [together.select_action(batch_of(seen)).numpy() for seen in observations]
    np.testing.assert_allclose(np.stack(found, axis=1), expected, atol=1e-6)


def test_the_tensors_are_the_saved_ones(saved: Path, exported: Path) -> None:
    ours, theirs = (load_file(folder / "model.safetensors") for folder in (saved, exported))
    assert set(ours) == set(theirs)
    assert all(torch.equal(ours[name], theirs[name]) for name in ours)
    about = json.loads((exported / "config.json").read_text())["about"]
    assert about == {"transfer": "s1-panda-lift", "seed": 0}


def test_a_missing_tensor_is_an_error(exported: Path, tmp_path: Path) -> None:
    folder = tmp_path / "damaged"
    shutil.copytree(exported, folder)
    tensors = load_file(folder / "model.safetensors")
    tensors.pop("decoder.output.bias")
    save_file(tensors, folder / "model.safetensors")
    with pytest.raises(RuntimeError, match=r"decoder\.output\.bias"):
        LfrPolicy.from_pretrained(folder)


def test_another_tasks_observation_is_refused(exported: Path) -> None:
    policy, _, _ = loaded(exported, LfrEnv(robot="panda", task="stack"))
    with pytest.raises(LfrError, match=r"\(17,\), expected \(11,\).*--env.task=lift"):
        policy.select_action(batch_of(np.zeros((1, 28))))


@pytest.mark.parametrize("robot", ["sawyer", "panda-joint_position"])
def test_another_arm_or_controller_is_refused(exported: Path, robot: str) -> None:
    """Even one whose action has as many dimensions, by which LeRobot could not tell it."""
    with pytest.raises(LfrError, match=f"{robot}: another robot or controller.*--env.robot=panda"):
        loaded(exported, LfrEnv(robot=robot, task="lift"))


def test_lerobot_cannot_make_or_train_one(exported: Path) -> None:
    with pytest.raises(ParameterError, match="lfr export"):
        LfrPolicy(LfrConfig(device="cpu"))
    policy, _, _ = loaded(exported)
    with pytest.raises(LfrError, match="transfer stage"):
        policy(batch_of(np.zeros((1, sum(SIZE)))))


def test_export_refuses_what_is_there_and_what_is_no_policy(saved: Path, tmp_path: Path) -> None:
    with pytest.raises(DataError, match="already"):
        export_policy(saved, tmp_path)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(DataError, match="missing"):
        export_policy(tmp_path / "nothing", tmp_path / "out")
    assert not (tmp_path / "out").exists()
