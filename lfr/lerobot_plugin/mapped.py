"""A mapping as a policy: the source's prior of the new task, G, and the target's decoder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lfr.data.own_columns import OwnColumns, own_columns
from lfr.errors import DataError
from lfr.external import external_arms
from lfr.mapping.saved_generators import load_generator, load_mapping_seen
from lfr.params import PARAMS
from lfr.scenarios import Transfer
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.library import pipeline_models
from lfr.skills.saved_models import load_prior, load_vae
from lfr.transfer.actor import SkillActor
from lfr.transfer.extended_policy import frozen_prior


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
    return MappedActor(actor, transfer, seen.seed, columns_of(transfer, prior.layout_names, params))


def columns_of(
    transfer: Transfer, names: Sequence[str], params: Path = PARAMS
) -> OwnColumns | None:
    """What of its own datasets a transfer's target sees and answers; None if it is simulated here.

    Args:
        names: what the policy calls what it sees.

    Raises:
        DataError: as `lfr.data.own_columns.own_columns`; or a column that LeRobot gives no policy.
    """
    arm = external_arms([transfer.target], params).get(transfer.target)
    if arm is None:
        return None
    found = own_columns(transfer.target, arm, transfer.task, transfer.common, names)
    seen = [part.column for part in found.selection.observation]
    lost = [column for column in seen if not column.startswith("observation.")]
    if found.selection.action.column != "action":
        lost.append(found.selection.action.column)
    if lost:
        raise DataError(
            "LeRobot gives a policy columns called `observation.*` and takes its `action`; rename "
            "the dataset's",
            file=params, column=f"external.arms.{transfer.target}", found=", ".join(lost),
        )  # fmt: skip
    return found
