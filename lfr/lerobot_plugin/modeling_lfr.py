"""A transferred policy as a LeRobot policy: the same networks, under the same tensor names."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_STATE
from torch import Tensor, nn

from lfr.data.resample import frames_of
from lfr.errors import LfrError
from lfr.lerobot_plugin.columns_processor import SELECTED
from lfr.lerobot_plugin.configuration_lfr import ActionFeature, LfrConfig
from lfr.transfer.model import actor_of
from lfr.transfer.network_kinds import network_kind


class LfrPolicy(PreTrainedPolicy):
    """The mean skill for an observation, carried out action by action.

    A batch is one of environments that were reset together: all choose their next skill at the
    same step.
    """

    config_class = LfrConfig  # pyright: ignore[reportAssignmentType]
    name = "lfr"  # pyright: ignore[reportAssignmentType]

    def __init__(self, config: LfrConfig, **_: Any) -> None:
        super().__init__(config)
        config.validate_features()
        _check_action(config)
        file = Path(config.pretrained_path or "") / "config.json"
        networks: dict[str, nn.Module] = {}
        for name, entry in config.networks.items():
            networks[name] = network_kind(entry["class"], file).network(**entry["shape"])
            self.add_module(name, networks[name].requires_grad_(False))
        self._actor = actor_of(networks, config.distribution, config.min_sigma)
        self._task = config.task_name
        self._observed = (SELECTED,) if config.columns else (OBS_STATE, OBS_ENV_STATE)
        self._ratio = float(config.columns.get("ratio", 1.0))  # control steps to an action
        self._waiting: list[deque[Tensor]] = []  # of each row
        self._chosen: list[int] = []  # actions of each row since its episode began

    @classmethod
    def from_pretrained(
        cls, pretrained_name_or_path: str | Path, *, strict: bool = True, **kwargs: Any
    ) -> LfrPolicy:
        """As LeRobot's, but a missing tensor is an error: such a policy would act at random."""
        return super().from_pretrained(pretrained_name_or_path, strict=strict, **kwargs)

    def reset(self) -> None:
        """Forget the skill under way; an episode begins."""
        self._waiting.clear()
        self._chosen.clear()

    @torch.no_grad()
    def select_action(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """The next action (B, A) in [-1, 1]; chooses a skill where the last has been carried out.

        Raises:
            LfrError: an observation of another size than the policy's task has.
        """
        rows = len(batch[self._observed[0]])
        if len(self._waiting) != rows:
            self._waiting, self._chosen = [deque() for _ in range(rows)], [0] * rows
        if not all(self._waiting):
            for row, skill in enumerate(self._skills(batch)):
                if not self._waiting[row]:
                    self._waiting[row].extend(self._repeated(skill, self._chosen[row]))
                    self._chosen[row] += len(skill)
        return torch.stack([waiting.popleft() for waiting in self._waiting])

    @torch.no_grad()
    def predict_action_chunk(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """The actions (B, n, A) of the next skills, as many as are carried out of every one.

        Raises:
            LfrError: an observation of another size than the policy's task has.
        """
        skills = [self._repeated(skill, 0) for skill in self._skills(batch)]
        return torch.stack([skill[: min(map(len, skills))] for skill in skills])

    def _repeated(self, skill: Tensor, chosen: int) -> Tensor:
        """Actions (n, A), each for as many control steps as it lasts; ``chosen`` came before."""
        lasts = [frames_of(chosen + step, self._ratio) for step in range(len(skill))]
        return skill.repeat_interleave(torch.tensor(lasts), dim=0)

    def _skills(self, batch: dict[str, Tensor]) -> Sequence[Tensor]:
        """The actions of the next skill of each row, (n, A), as many as are carried out of it."""
        for key in self._observed:
            if key != SELECTED:  # whose columns are held to their sizes as they are selected
                self._check(key, tuple(batch[key].shape[1:]))
        observations = torch.cat([batch[key] for key in self._observed], dim=-1)  # (B, D)
        return self._actor.decoder.carry_out(self._actor.choose(observations).z, observations)

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, dict | None]:
        """Raises LfrError: a transferred policy does not learn from a dataset."""
        raise LfrError(
            "a policy of type lfr learns by the pipeline's transfer stage, not by lerobot-train"
        )

    def get_optim_params(self) -> Any:
        return self.parameters()

    def _check(self, key: str, found: tuple[int, ...]) -> None:
        features = self.config.input_features or {}
        expected = tuple(features[key].shape)
        if found != expected:
            raise LfrError(
                f"{key} has shape {found}, expected {expected}: the policy has learned "
                f"{self._task}, pass --env.task={self._task}"
            )


def _check_action(config: LfrConfig) -> None:
    """Raises LfrError where the policy is to act on another arm, or through another controller."""
    acting = (config.output_features or {}).get(ACTION)
    if isinstance(acting, ActionFeature) and acting.robot != config.robot:
        raise LfrError(
            f"--env.robot is {acting.robot}: another robot or controller than the policy's, "
            f"pass --env.robot={config.robot}"
        )
