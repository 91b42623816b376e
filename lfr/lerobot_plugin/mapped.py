"""A mapping as a policy: the source's prior of the new task, G, and the target's decoder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.columns import Columns
from lfr.data.external import selected
from lfr.data.selection import Chosen, Selection, select
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError
from lfr.external import ExternalArm, external_arms
from lfr.mapping.saved_generators import load_generator, load_mapping_seen
from lfr.params import PARAMS
from lfr.scenarios import Transfer
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.library import pipeline_models
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import load_prior, load_vae
from lfr.transfer.actor import SkillActor
from lfr.transfer.extended_policy import frozen_prior


@dataclass(frozen=True)
class OwnColumns:
    """What of an arm's datasets a policy sees and answers.

    Attributes:
        features: of the columns that it needs, as the dataset describes them.
        selection: which of their numbers, and what the action's are.
        fps: control steps per second.
    """

    features: dict[str, Any]
    selection: Selection
    fps: float

    def described(self) -> dict[str, Any]:
        """As `lfr.lerobot_plugin.columns_processor` wants it, and JSON can hold it."""
        space, action = self.selection.space, self.selection.action
        return {
            "observation": [
                {"column": part.column, "size": self._size(part), "places": list(part.places),
                 "names": list(part.names), "unit": part.unit}
                for part in self.selection.observation
            ],
            "action": {"names": list(space.names), "places": list(action.places),
                       "low": list(space.low), "high": list(space.high)},
        }  # fmt: skip

    def _size(self, part: Chosen) -> int:
        return int(self.features[part.column]["shape"][0])


@dataclass(frozen=True)
class MappedActor:
    """What a mapping gives before any learning on the target.

    Attributes:
        columns: the target's own; None for an arm that is simulated here.
    """

    actor: SkillActor
    transfer: Transfer
    seed: int
    columns: OwnColumns | None


def mapped_actor(folder: Path, params: Path = PARAMS) -> MappedActor:
    """The policy of ``models/mapping/<transfer>``, with the skill models that lie beside it.

    Args:
        folder: of G and F; those of the skills are found from it as the pipeline leaves them.
        params: says what the transfer is, and what the columns of external arms are.

    Raises:
        DataError: a model is missing, damaged or of other skills; or the target's datasets have
            not what the source's prior of the new task is to see, or actions that are left out.
        LfrError: ``params`` knows no such transfer.
    """
    seen = load_mapping_seen(folder / "g")
    transfer = transfer_named(seen.transfer, params)
    scenario = scenario_named(transfer.scenario, params)
    arms = external_arms(scenario.robots, params)
    skills = pipeline_models(scenario, transfer, arms, folder.resolve().parent.parent)
    expected = skills["source"].name, skills["target"].name
    if seen.skills != expected:
        raise DataError("the mapping is of other skills; train it again",
                        file=folder / "g" / "config.json", found=" and ".join(seen.skills),
                        expected=" and ".join(expected))  # fmt: skip
    prior = load_prior(skills["source"].prior(transfer.task))
    policy = frozen_prior(prior, load_generator(folder / "g"))
    actor = SkillActor(policy, policy, load_vae(skills["target"].vae()))
    columns = None
    if transfer.target in arms:
        columns = _own_columns(arms, transfer, prior)
    return MappedActor(actor, transfer, seen.seed, columns)


def _own_columns(
    arms: Mapping[str, ExternalArm], transfer: Transfer, prior: SkillPrior
) -> OwnColumns:
    """Of the target's datasets those columns that give what the prior sees, in its order."""
    arm, task = arms[transfer.target], transfer.task
    if task in arm.tasks:
        shown = [(task, selected(arm, task))]
    else:  # nobody has shown it the task: it sees what it sees elsewhere
        shown = [(common, _selected_as(arm, common)) for common in transfer.common]
    found = next((one for one in shown if one[1].observation_names == prior.layout_names), None)
    if found is None:
        raise DataError(
            f"{transfer.target} sees something else than {transfer.source}'s prior of {task}; list "
            f"{task} among its tasks, with the observation",
            file=PARAMS, column=f"external.arms.{transfer.target}",
            found=", ".join(shown[0][1].observation_names),
            expected=", ".join(prior.layout_names),
        )  # fmt: skip
    dataset, selection = found
    files = DatasetFiles.open(arm.dataset(dataset))
    _check_whole(files, selection)
    needed = dict.fromkeys([*(part.column for part in selection.observation),
                            selection.action.column])  # fmt: skip
    features = {column: files.features[column] for column in needed}
    return OwnColumns(features, selection, arm.fps)


def _selected_as(arm: ExternalArm, task: str) -> Selection:
    """The arm's own parts, where it has any, of a task's dataset."""
    if not arm.observation:
        return selected(arm, task)
    return select(DatasetFiles.open(arm.dataset(task)), Columns(arm.observation, arm.action))


def _check_whole(files: DatasetFiles, selection: Selection) -> None:
    """Raises DataError where a policy would not know what to answer in some dimension."""
    size = int(files.features[selection.action.column]["shape"][0])
    missing = sorted(set(range(size)) - set(selection.action.places))
    if missing:
        raise DataError(
            "the arm's action leaves out numbers of its column, which a policy could not answer; "
            "a policy needs an arm that was trained with all of them",
            file=files.path / "meta" / "info.json", column=selection.action.column,
            found=f"dims {', '.join(map(str, selection.action.places))}",
            expected=f"all {size}",
        )  # fmt: skip
