"""What LeRobot does to a batch before and after a policy: its own steps, and an arm's columns."""

from __future__ import annotations

from typing import Any

from lerobot.processor import (
    PolicyAction,
    PolicyProcessorPipeline,
    make_default_policy_processor_steps,
    make_policy_processor_pipelines,
)
from torch import Tensor

from lfr.lerobot_plugin.columns_processor import PhysicalAction, SelectColumns
from lfr.lerobot_plugin.configuration_lfr import LfrConfig


def make_lfr_pre_post_processors(
    config: LfrConfig, dataset_stats: dict[str, dict[str, Tensor]] | None = None
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]],
    PolicyProcessorPipeline[PolicyAction, PolicyAction],
]:
    """Names, batch dimension and device; of an arm known by its datasets the selection of their
    columns, and its actions in their units. Nothing is scaled by statistics.

    The name is LeRobot's convention for a policy of type `lfr`.
    """
    steps = make_default_policy_processor_steps(config, dataset_stats)
    before = [steps.rename_observations, steps.add_batch_dim, steps.to_device, steps.normalize]
    after = [steps.unnormalize, steps.to_cpu]
    if config.columns:
        before.append(SelectColumns(config.columns["observation"]))
        after.append(PhysicalAction(**config.columns["action"]))
    return make_policy_processor_pipelines(before, after)
