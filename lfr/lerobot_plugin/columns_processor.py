"""From an arm's own columns to what a policy sees, and from its actions back, as LeRobot's steps.

A folder of LeRobot's holds them beside the policy, each by the path of its class and what it was
made with, so that whoever loads the folder need not know what `params.yaml` said.

    columns of the dataset -> SelectColumns -> "observation.selected" -> LfrPolicy
    action of the dataset <- PhysicalAction <- action in [-1, 1]      <-
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import torch
from lerobot.configs import PipelineFeatureType, PolicyFeature
from lerobot.processor import ObservationProcessorStep, PolicyActionProcessorStep
from numpy.typing import NDArray
from torch import Tensor

from lfr.columns import ActionSpace
from lfr.conversion import Conversion
from lfr.data.selection import Chosen
from lfr.errors import LfrError
from lfr.records import from_mapping

SELECTED = "observation.selected"
Features = dict[PipelineFeatureType, dict[str, PolicyFeature]]


@dataclass
class SelectColumns(ObservationProcessorStep):
    """Puts numbers of several columns into one vector, ``observation.selected`` (B, D), float32.

    Attributes:
        parts: one after the other, each with ``column``, its ``size``, the ``places`` of the
            numbers in it, the ``names`` of what they become, the ``conversion`` by which, and
            ``minus``, column, size and places of what is taken off them before that, or None.
    """

    parts: list[dict[str, Any]] = field(default_factory=list)

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        """Raises LfrError where a column is missing, or has another size than the dataset's."""
        taken = [self._taken(observation, part) for part in self.parts]
        return {**observation, SELECTED: torch.cat(taken, dim=-1).float()}

    def get_config(self) -> dict[str, Any]:
        return asdict(self)

    def transform_features(self, features: Features) -> Features:
        return features

    @staticmethod
    def _taken(observation: dict[str, Any], part: dict[str, Any]) -> Tensor:
        minus, how = part["minus"], part["conversion"]
        sizes = {one["column"]: one["size"] for one in (part, minus) if one}

        def column(name: str) -> NDArray:
            values = observation.get(name)
            if values is None:
                raise LfrError(f"{name} is missing, of which the policy needs {_listed(part)}")
            if values.shape[-1] != sizes[name]:
                raise LfrError(
                    f"{name} has {values.shape[-1]} numbers, expected {sizes[name]} as in the "
                    "datasets that the policy was trained on"
                )
            return values.cpu().numpy()

        chosen = Chosen(
            part["column"], tuple(part["places"]), tuple(part["names"]),
            from_mapping(Conversion, how, part["column"]),
            minus and (minus["column"], tuple(minus["places"])),
        )  # fmt: skip
        try:
            return torch.from_numpy(chosen.values(column)).to(observation[part["column"]].device)
        except ValueError as error:
            raise LfrError(f"{part['column']}: {error}") from None


@dataclass
class PhysicalAction(PolicyActionProcessorStep):
    """Brings actions (B, A) in [-1, 1] into the units and the order of the dataset's column.

    Attributes:
        names: of each dimension of the policy's action.
        places: where each stands in the column.
        low, high: the values of -1 and of 1.
    """

    names: list[str] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    low: list[float] = field(default_factory=list)
    high: list[float] = field(default_factory=list)

    def action(self, action: Tensor) -> Tensor:
        space = ActionSpace(tuple(self.names), tuple(self.low), tuple(self.high))
        physical = torch.empty_like(action)
        physical[..., self.places] = torch.from_numpy(space.physical(action.numpy()))
        return physical

    def get_config(self) -> dict[str, Any]:
        return asdict(self)

    def transform_features(self, features: Features) -> Features:
        return features


def _listed(part: dict[str, Any]) -> str:
    return ", ".join(part["names"])
