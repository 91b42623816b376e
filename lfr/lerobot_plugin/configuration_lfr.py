"""`--policy.type=lfr`: what LeRobot has to know of a transferred policy before it builds it.

The names of this module, of `modeling_lfr`, of `processor_lfr` and of what they define are
LeRobot's convention: it finds the one by replacing a word in the name of the other
(`lerobot.policies.factory`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from lerobot.configs import FeatureType, NormalizationMode, PolicyFeature, PreTrainedConfig
from lerobot.optim import AdamConfig, LRSchedulerConfig, OptimizerConfig
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_STATE
from lerobot.utils.feature_utils import dataset_to_policy_features

from lfr.embodiments import embodiment
from lfr.errors import ParameterError
from lfr.spaces import ROBOT_STATE
from lfr.tasks import task


@PreTrainedConfig.register_subclass("lfr")
@dataclass
class LfrConfig(PreTrainedConfig):
    """A policy over skills, with the decoder that carries them out (`lfr.transfer.model`).

    Attributes:
        robot, task_name: the embodiment and the task that it has learned.
        networks: of each network its class and the arguments of its constructor.
        distribution: what the policy draws its skills from (`lfr.transfer.distribution`).
        min_sigma: added in quadrature to its sigma (`lfr.transfer.extended_policy.MappedPolicy`).
        columns: of an arm that is known by its datasets alone, which numbers of which columns the
            policy sees and what its actions are there (`lfr.lerobot_plugin.columns_processor`).
        about: all else that was saved with it: transfer, method, seed, parameters, provenance.
    """

    robot: str = ""
    task_name: str = ""
    networks: dict[str, Any] = field(default_factory=dict)
    distribution: str = "gaussian"
    min_sigma: float = 0.0
    columns: dict[str, Any] = field(default_factory=dict)
    about: dict[str, Any] = field(default_factory=dict)
    # The networks scale their inputs themselves.
    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: dict.fromkeys(
            ("STATE", "ENV", "ACTION"), NormalizationMode.IDENTITY
        )
    )

    @property
    def observation_delta_indices(self) -> None:
        return None

    @property
    def action_delta_indices(self) -> None:
        return None

    @property
    def reward_delta_indices(self) -> None:
        return None

    def validate_features(self) -> None:
        """Raises ParameterError for a policy without networks, such as `--policy.type=lfr` gives.

        Its networks come from the pipeline, by `lfr export`; LeRobot cannot make them.
        """
        if not self.networks:
            raise ParameterError(
                "a policy of type lfr has no networks of its own; "
                "`lfr export` writes one for --policy.path"
            )

    def get_optimizer_preset(self) -> OptimizerConfig:
        return AdamConfig()

    def get_scheduler_preset(self) -> LRSchedulerConfig | None:
        return None


class ActionFeature(PolicyFeature):
    """An action and the embodiment that it belongs to.

    LeRobot hands an environment's features to the policy as they are, and nothing else. The
    embodiment is no field of the dataclass, so that LeRobot's files know nothing of it.
    """

    def __init__(self, robot: str) -> None:
        super().__init__(FeatureType.ACTION, (embodiment(robot).action.size,))
        self.robot = robot


def own_features(
    columns: dict[str, Any],
) -> tuple[dict[str, PolicyFeature], dict[str, PolicyFeature]]:
    """As `features_of`, of the columns of an arm's own datasets; one of them is ``action``.

    Args:
        columns: as a dataset's ``meta/info.json`` has them under ``features``.
    """
    found = dataset_to_policy_features(columns)
    answered = {key: one for key, one in found.items() if one.type is FeatureType.ACTION}
    return {key: one for key, one in found.items() if key not in answered}, answered


def features_of(
    robot: str, task_name: str
) -> tuple[dict[str, PolicyFeature], dict[str, PolicyFeature]]:
    """What a policy of an embodiment for a task is given and what it answers, by LeRobot's names.

    Raises:
        UnknownNameError: there is no such embodiment or task.
    """
    environment = task(task_name).environment
    given = {
        OBS_STATE: PolicyFeature(FeatureType.STATE, (ROBOT_STATE.size,)),
        OBS_ENV_STATE: PolicyFeature(FeatureType.ENV, (environment.size,)),
    }
    return given, {ACTION: ActionFeature(robot)}
