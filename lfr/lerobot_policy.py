"""Any policy in LeRobot's format, asked about columns of numbers and pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.errors import LfrError

PLUGIN = "lfr.lerobot_plugin"  # by which LeRobot finds this project's policies


class LeRobotPolicy:
    """A policy of a folder, with the steps that LeRobot takes before and after it.

    Args:
        folder: as `save_pretrained` and `lfr export` write it.

    Attributes:
        columns: names of what it must be given.

    Raises:
        LfrError: there is no policy that LeRobot can load; or, of `act`, whatever it raises.
    """

    def __init__(self, folder: Path) -> None:
        from lerobot.configs import PreTrainedConfig
        from lerobot.configs.parser import load_plugin
        from lerobot.policies import get_policy_class, make_pre_post_processors
        from lerobot.utils.import_utils import register_third_party_plugins

        self._folder = folder
        if not (folder / "config.json").is_file():
            raise LfrError(
                f"--policy {folder}: no policy in LeRobot's format; `lfr export` writes one"
            )
        register_third_party_plugins()
        load_plugin(PLUGIN)
        try:
            config = PreTrainedConfig.from_pretrained(folder)
            config.pretrained_path = folder
            policy = get_policy_class(config.type).from_pretrained(folder, config=config)
            self._policy: Any = policy.eval()
            self._before, self._after = make_pre_post_processors(config, str(folder))
        except LfrError:
            raise
        except Exception as error:  # draccus, safetensors and LeRobot each raise their own
            raise LfrError(f"--policy {folder}: LeRobot cannot load it: {error}") from error
        self.columns = tuple(config.input_features or ())

    def reset(self) -> None:
        """An episode begins."""
        self._policy.reset()

    def act(self, columns: Mapping[str, NDArray[Any]], task: str) -> NDArray[np.float64]:
        """The action (A,), in the dataset's units.

        Args:
            columns: those it must be given: vectors (D,), and pictures (3, H, W) in [0, 1].
            task: in words.
        """
        import torch

        try:
            with torch.inference_mode():
                batch: dict[str, Any] = {
                    key: torch.as_tensor(values)[None] for key, values in columns.items()
                }
                asked = self._before({**batch, "task": [task]})
                return self._after(self._policy.select_action(asked))[0].double().numpy()
        except LfrError:
            raise
        except Exception as error:  # whatever a policy of somebody's raises
            raise LfrError(f"--policy {self._folder} does not act: {error}") from error
