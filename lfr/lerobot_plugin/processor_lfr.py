"""What LeRobot does to a batch before and after a transferred policy: its own steps, no scaling."""

from __future__ import annotations

from typing import Any

from lerobot.processor import (
    PolicyAction,
    PolicyProcessorPipeline,
    make_default_pre_post_processors,
)
from torch import Tensor

from lfr.lerobot_plugin.configuration_lfr import LfrConfig


def make_lfr_pre_post_processors(
    config: LfrConfig, dataset_stats: dict[str, dict[str, Tensor]] | None = None
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]],
    PolicyProcessorPipeline[PolicyAction, PolicyAction],
]:
    """Names, batch dimension and device; every feature is left as it is, whatever its statistics.

    The name is LeRobot's convention for a policy of type `lfr`.
    """
    return make_default_pre_post_processors(config, dataset_stats)
