"""Columns as a LeRobot policy takes them, against the reader that models are trained by."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from lerobot.configs import PipelineFeatureType
from lerobot.processor import (
    PolicyProcessorPipeline,
    policy_action_to_transition,
    transition_to_policy_action,
)

from lfr.data.own_columns import OwnColumns
from lfr.data.selection import select
from lfr.data.tables import DatasetFiles, values
from lfr.data.windows import read_dataset
from lfr.errors import LfrError
from lfr.external import external
from lfr.lerobot_plugin.columns_processor import SELECTED, PhysicalAction, SelectColumns
from tests.external import made_up

# The crane's: numbers in another order, in millimetres, two columns; an action with bounds, whose
# dimensions are named out of order.
SWAPPED = made_up.EXTERNAL.replace(
    "action: {column: action, low: [-500, -500, 0], high: [500, 500, 1]}",
    "action: {column: action, dims: [hand, vx, vy], low: [0, -500, -500], high: [1, 500, 500]}",
)


@pytest.fixture(scope="module")
def crane(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("crane")
    made_up.write_both(folder / "data/external", episodes=2)
    (folder / "params.yaml").write_text(SWAPPED)
    return folder


def steps_of(folder: Path) -> tuple[SelectColumns, PhysicalAction]:
    arm = external(folder / "params.yaml").arms["crane"]
    files = DatasetFiles.open(folder / arm.dataset("park"))
    columns = OwnColumns(files.features, select(files, arm.columns("park")), arm.fps).described()
    return SelectColumns(columns["observation"]), PhysicalAction(**columns["action"])


def test_they_are_the_readers_numbers_and_the_datasets_actions(crane: Path, tmp_path: Path) -> None:
    """To the last bit, and also once LeRobot has written them to a file and read them again."""
    arm = external(crane / "params.yaml").arms["crane"]
    files = DatasetFiles.open(crane / arm.dataset("park"))
    rows = read_dataset(files.path, arm.columns("park"))
    table = files.data(["observation.state", "observation.goal", "action"])
    recorded = {key: torch.from_numpy(np.array(values(table, key))) for key in table.column_names}
    before, after = steps_of(crane)
    PolicyProcessorPipeline(steps=[before], name="before").save_pretrained(tmp_path)
    PolicyProcessorPipeline(steps=[after], name="after").save_pretrained(tmp_path)
    read = PolicyProcessorPipeline.from_pretrained(tmp_path, config_filename="before.json")
    answer = PolicyProcessorPipeline.from_pretrained(
        tmp_path, config_filename="after.json", to_transition=policy_action_to_transition,
        to_output=transition_to_policy_action,
    )  # fmt: skip
    np.testing.assert_array_equal(read(recorded)[SELECTED].numpy(), rows.observations.numpy())
    physical = rows.action_space.physical(rows.actions.numpy())  # hand, vx, vy
    found = answer(rows.actions).numpy()
    np.testing.assert_array_equal(found, physical[:, [1, 2, 0]])
    np.testing.assert_allclose(found, recorded["action"].numpy(), atol=1e-4)
    features = {PipelineFeatureType.OBSERVATION: {}}
    assert before.transform_features(features) == after.transform_features(features) == features


def test_a_column_that_is_missing_or_of_another_size_is_told(crane: Path) -> None:
    before, _ = steps_of(crane)
    whole = {"observation.state": torch.zeros(1, 3), "observation.goal": torch.zeros(1, 2)}
    assert before.observation(whole)[SELECTED].shape == (1, 4)
    with pytest.raises(LfrError, match=r"observation\.goal is missing, of which.*goal_pos\.x"):
        before.observation({"observation.state": whole["observation.state"]})
    with pytest.raises(LfrError, match=r"observation\.state has 4 numbers, expected 3"):
        before.observation({**whole, "observation.state": torch.zeros(1, 4)})
