"""LeRobot's own evaluation loop beside ours: the same starts, and success counted alike.

Both are given the scripted expert, which waits where the cube lies to the left: so there are
successes and failures, and no network.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.envs import make_env
from lerobot.policies import make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.scripts.lerobot_eval import eval_policy
from torch import Tensor

from lfr.demos.expert import Expert, ExpertParams
from lfr.lerobot_plugin.configuration_lfr import LfrConfig, features_of
from lfr.lerobot_plugin.env_config import LfrEnv
from lfr.policies import roll_out
from lfr.seeds import episode_seed
from lfr.sim.simulation import simulation
from lfr.tasks import task

EPISODES = 5
LAYOUT = task("lift").observation


class Fastidious:
    """Lifts a cube on the right, and waits otherwise. One action to a skill."""

    def __init__(self) -> None:
        self.expert = Expert(task("lift"), LAYOUT, ExpertParams())

    def reset(self, seed: int) -> None: ...

    def act(self, observation: np.ndarray) -> np.ndarray:
        seen = observation.astype(np.float32).astype(np.float64)  # as LeRobot hands it on
        if seen[LAYOUT.index("cube_pos.y")] > 0:
            return np.zeros((1, 7))
        return self.expert.clean(seen).astype(np.float32).astype(np.float64)[None]


class FastidiousPolicy(PreTrainedPolicy):
    config_class = LfrConfig  # pyright: ignore[reportAssignmentType]
    name = "fastidious"  # pyright: ignore[reportAssignmentType]

    def reset(self) -> None: ...

    def select_action(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        parts = (batch["observation.state"], batch["observation.environment_state"])
        rows = torch.cat(parts, dim=-1).double().numpy()
        return torch.from_numpy(np.concatenate([Fastidious().act(row) for row in rows])).float()

    def predict_action_chunk(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        raise NotImplementedError

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, dict | None]:
        raise NotImplementedError

    def get_optim_params(self) -> Any:
        raise NotImplementedError


@dataclass
class Summing:
    """The engine, with the dense rewards of an episode added up."""

    def __post_init__(self) -> None:
        self.engine = simulation("panda", "lift")
        self.task, self.layout = self.engine.task, self.engine.layout
        self.horizon, self.totals = self.engine.horizon, []

    def reset(self, seed: int) -> np.ndarray:
        self.totals.append(0.0)
        return self.engine.reset(seed)

    def step(self, actions: np.ndarray, stop_on_success: bool = False) -> Any:
        steps = self.engine.step(actions, stop_on_success=stop_on_success)
        self.totals[-1] += float(steps.rewards.sum())
        return steps


@pytest.mark.parametrize("together", [1, 2])
def test_the_same_success_and_return_for_each_start(together: int) -> None:
    judge = Summing()
    seeds = [episode_seed("held-out", index) for index in range(EPISODES)]
    ours = roll_out(Fastidious(), judge, seeds)
    assert {outcome.success for outcome in ours} == {True, False}

    given, answered = features_of("panda", "lift")
    config = LfrConfig(device="cpu", input_features=given, output_features=answered)
    config_of_env = LfrEnv(robot="panda", task="lift")
    before, after = make_pre_post_processors(config)
    theirs = eval_policy(
        make_env(config_of_env, n_envs=together)["lfr"][0],
        FastidiousPolicy(config),
        *config_of_env.get_env_processors(),
        before,
        after,
        n_episodes=EPISODES,
        start_seed=0,
    )["per_episode"]
    assert [episode["seed"] for episode in theirs] == list(range(EPISODES))
    assert [episode["success"] for episode in theirs] == [outcome.success for outcome in ours]
    returns = [episode["sum_reward"] for episode in theirs]
    np.testing.assert_allclose(returns, judge.totals, rtol=1e-12)


def test_the_config_is_found_by_its_name() -> None:
    assert PreTrainedConfig.get_choice_class("lfr") is LfrConfig
