"""Loads an exported policy as LeRobot does, alone in a process, and acts by it; prints JSON.

    python rollout_as_lerobot.py <policy> <dataset> <episode>

Two questions: the actions for an episode's recorded rows, and LeRobot's own rollout in an
environment that is none of this project's.
"""

import json
import sys
from pathlib import Path
from typing import Any

import torch
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TimeLimit
from lerobot.configs import PreTrainedConfig
from lerobot.datasets import LeRobotDataset
from lerobot.envs.utils import FreezeAfterEpisodeEnd
from lerobot.policies import get_policy_class, make_pre_post_processors
from lerobot.processor import PolicyProcessorPipeline
from lerobot.scripts.lerobot_eval import rollout
from lerobot.utils.import_utils import register_third_party_plugins

from tests.external.plane import Plane


def loaded(folder: Path) -> tuple[Any, Any, Any]:
    register_third_party_plugins()
    config = PreTrainedConfig.from_pretrained(folder)
    config.pretrained_path = folder
    policy = get_policy_class(config.type).from_pretrained(folder, config=config)
    return policy, *make_pre_post_processors(config, str(folder))


def on_rows(folder: Path, root: Path, episode: int) -> list[list[float]]:
    policy, before, after = loaded(folder)
    dataset = LeRobotDataset(f"theirs/{root.name}", root=root, episodes=[episode])
    policy.reset()
    actions = []
    for number in range(len(dataset)):
        batch = before({key: value for key, value in dataset[number].items()})
        with torch.inference_mode():
            actions.append(after(policy.select_action(batch))[0].tolist())
    return actions


def in_environment(folder: Path) -> list[dict[str, Any]]:
    """Observations and actions of two episodes."""
    policy, before, after = loaded(folder)
    nothing = PolicyProcessorPipeline(steps=[])
    episodes = []
    for seed in (0, 1):
        make = [lambda: FreezeAfterEpisodeEnd(TimeLimit(Plane(quadrant=(1, -1)), 40))]
        batch = SyncVectorEnv(make, autoreset_mode=AutoresetMode.NEXT_STEP)
        with torch.no_grad():
            found = rollout(
                batch, policy, nothing, nothing, before, after, [seed], return_observations=True
            )
        seen = found["observation"]["observation.state"][0]
        episodes.append({"seen": seen.tolist(), "actions": found["action"][0].tolist()})
    return episodes


if __name__ == "__main__":
    policy, dataset, episode = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
    print(json.dumps({
        "actions": on_rows(policy, dataset, episode),
        "episodes": in_environment(policy),
        "modules": sorted(name for name in sys.modules if name.startswith("lfr")),
    }))  # fmt: skip
