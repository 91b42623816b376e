"""What of its own datasets' columns an arm's policy sees and answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from lfr.columns import Columns
from lfr.data.external import selected
from lfr.data.selection import Selection, select
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError
from lfr.external import ExternalArm
from lfr.params import PARAMS


@dataclass(frozen=True)
class OwnColumns:
    """What of an arm's datasets a policy sees and answers.

    Attributes:
        features: of the columns that it needs, as the dataset describes them.
        selection: which of their numbers, and what the action's are.
        fps: control steps per second, of which the policy's actions are carried out for several
            where it is asked less often.
        ratio: control steps to one of the policy's (`lfr.data.resample`).
    """

    features: dict[str, Any]
    selection: Selection
    fps: float
    ratio: float = 1.0

    def described(self) -> dict[str, Any]:
        """As `lfr.lerobot_plugin.columns_processor` wants it, and JSON can hold it."""
        space, action = self.selection.space, self.selection.action
        return {
            "observation": [
                {"column": part.column, "size": self.size_of(part.column),
                 "places": list(part.places), "names": list(part.names),
                 "conversion": asdict(part.conversion),
                 "minus": part.minus and {"column": part.minus[0], "places": list(part.minus[1]),
                                          "size": self.size_of(part.minus[0])}}
                for part in self.selection.observation
            ],
            "action": {"names": list(space.names), "places": list(action.places),
                       "low": list(space.low), "high": list(space.high)},
            "ratio": self.ratio,
        }  # fmt: skip

    def size_of(self, column: str) -> int:
        """How many numbers a column has."""
        return int(self.features[column]["shape"][0])


def own_columns(
    robot: str, arm: ExternalArm, task: str, others: Sequence[str], names: Sequence[str]
) -> OwnColumns:
    """Of an arm's datasets those columns that give what a policy for ``task`` sees, in its order.

    Args:
        others: tasks whose datasets say what it sees, where nobody has shown it this one.
        names: what the policy calls what it sees.

    Raises:
        DataError: the arm does not see that, or its action leaves out numbers of its column.
    """
    if task in arm.tasks:
        shown = [(task, selected(arm, task))]
    else:
        shown = [(other, _selected_as(arm, other)) for other in others]
    found = next((one for one in shown if one[1].observation_names == tuple(names)), None)
    if found is None:
        raise DataError(
            f"{robot} sees something else than the policy of {task}; list {task} among its tasks, "
            "with the observation",
            file=PARAMS, column=f"external.arms.{robot}",
            found=", ".join(shown[0][1].observation_names), expected=", ".join(names),
        )  # fmt: skip
    dataset, selection = found
    files = DatasetFiles.open(arm.dataset(dataset))
    _check_whole(files, selection)
    observed = [column for part in selection.observation for column in part.columns]
    needed = dict.fromkeys([*observed, selection.action.column])
    features = {column: files.features[column] for column in needed}
    return OwnColumns(features, selection, arm.fps, arm.fps / arm.rate)


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
