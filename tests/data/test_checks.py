"""Each thing that spoils a dataset is refused with its file, episode and column."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lfr.data.checks import check_dataset
from lfr.data.windows import read_dataset
from lfr.errors import DataError

from . import made_up
from .conftest import LENGTHS

DATA = "data/chunk-000/file-000.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
LAYOUT = made_up.layout()


@pytest.fixture
def dataset(packed: Path, tmp_path: Path) -> Path:
    return shutil.copytree(packed, tmp_path / "panda-lift")


def edit_info(dataset: Path, edit: Callable[[dict[str, Any]], Any]) -> None:
    file = dataset / "meta/info.json"
    info = json.loads(file.read_text())
    edit(info)
    file.write_text(json.dumps(info))


def edit_table(file: Path, edit: Callable[[pa.Table], pa.Table]) -> None:
    pq.write_table(edit(pq.read_table(file)), file)


def with_value(table: pa.Table, column: str, row: int, value: object) -> pa.Table:
    values = table[column].to_pylist()
    values[row] = value
    i = table.column_names.index(column)
    return table.set_column(i, table.schema.field(i), pa.array(values, table.schema.field(i).type))


def test_a_sound_dataset_passes(packed: Path) -> None:
    check_dataset(packed)
    check_dataset(packed, features=LAYOUT, fps=20, robot="panda", task="lift")


def test_expectations_are_compared(packed: Path) -> None:
    other = made_up.layout(("can_pos.x", "can_pos.y", "can_pos.z"))
    wider = made_up.layout((*made_up.ENVIRONMENT_NAMES, "cube_yaw.cos"))
    for expected, message in (
        ({"fps": 30}, r"another fps: .*info\.json, found 20, expected 30"),
        ({"robot": "sawyer"}, r"another robot or controller: .*found panda, expected sawyer"),
        ({"robot": "panda-joint_position"}, r"robot or controller.*expected panda-joint_position"),
        ({"task": "stack"}, r"another task: .*found lift, expected stack"),
        ({"features": other}, r"another names.*column observation.environment_state.*cube_pos.x"),
        ({"features": wider}, r"another shape.*environment_state, found \[3\], expected \[4\]"),
    ):
        with pytest.raises(DataError, match=message) as caught:
            check_dataset(packed, **expected)
        assert "\n" not in str(caught.value)


def test_a_missing_column(dataset: Path) -> None:
    edit_table(dataset / DATA, lambda t: t.drop_columns(["action"]))
    for reader in (check_dataset, read_dataset):
        with pytest.raises(
            DataError, match=r"column is missing: .*file-000.parquet, column action"
        ):
            reader(dataset)
    edit_info(dataset, lambda info: info["features"].pop("action"))
    for reader in (check_dataset, read_dataset):
        with pytest.raises(DataError, match=r"column is missing: .*info.json, column action"):
            reader(dataset)


def test_another_shape_in_the_rows_than_in_the_info(dataset: Path) -> None:
    def narrow(table: pa.Table) -> pa.Table:
        i = table.column_names.index("action")
        values = pa.array(
            [row[:6] for row in table["action"].to_pylist()], pa.list_(pa.float32(), 6)
        )
        return table.set_column(i, "action", values)

    edit_table(dataset / DATA, narrow)
    with pytest.raises(DataError, match=r"column action, found \(6,\), expected \(7,\)"):
        check_dataset(dataset)


def test_lists_of_different_lengths(dataset: Path) -> None:
    def ragged(table: pa.Table) -> pa.Table:
        i = table.column_names.index("action")
        values = [row[: 6 + n % 2] for n, row in enumerate(table["action"].to_pylist())]
        return table.set_column(i, "action", pa.array(values, pa.list_(pa.float32())))

    edit_table(dataset / DATA, ragged)
    with pytest.raises(DataError, match=r"column action, found lists of lengths \[6, 7\]"):
        check_dataset(dataset)


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    row=st.integers(0, sum(LENGTHS) - 1),
    dimension=st.integers(0, 3),
    value=st.sampled_from([float("nan"), float("inf"), -float("inf")]),
)
def test_a_value_that_is_not_finite_is_placed(
    packed: Path, tmp_path: Path, row: int, dimension: int, value: float
) -> None:
    bad = tmp_path / "bad"
    shutil.rmtree(bad, ignore_errors=True)
    shutil.copytree(packed, bad)
    table = pq.read_table(bad / DATA)
    state = table["observation.state"].to_pylist()[row]
    state[dimension] = value
    pq.write_table(with_value(table, "observation.state", row, state), bad / DATA)
    episode = table["episode_index"].to_pylist()[row]
    frame = table["frame_index"].to_pylist()[row]
    with pytest.raises(
        DataError, match=rf"episode {episode}, column observation\.state.* in frame {frame},"
    ):
        check_dataset(bad)


def test_a_missing_value(dataset: Path) -> None:
    edit_table(dataset / DATA, lambda t: with_value(t, "next.reward", 3, None))
    with pytest.raises(DataError, match=r"column next.reward, found 1 missing values"):
        check_dataset(dataset)


def test_no_successful_episode(dataset: Path) -> None:
    def fail(table: pa.Table) -> pa.Table:
        i = table.column_names.index("success")
        return table.set_column(i, "success", pa.array([False] * len(table)))

    edit_table(dataset / EPISODES, fail)
    with pytest.raises(
        DataError, match=r"no successful episode.*found 0 of 4, expected at least 1"
    ):
        check_dataset(dataset)


def test_successes_of_which_some_are_not_said(dataset: Path) -> None:
    """As merging leaves them, where one dataset has no such column."""

    def said(*values: object) -> Callable[[pa.Table], pa.Table]:
        def put(table: pa.Table) -> pa.Table:
            i = table.column_names.index("success")
            return table.set_column(i, "success", pa.array(values, pa.bool_()))

        return put

    for values in ((True, None, None, False), (None,) * 4):
        edit_table(dataset / EPISODES, said(*values))
        check_dataset(dataset)
    edit_table(dataset / EPISODES, said(False, None, False, None))
    with pytest.raises(DataError, match=r"no successful episode.*found 0 of 2"):
        check_dataset(dataset)


@pytest.mark.parametrize("name", [DATA, EPISODES])
@pytest.mark.parametrize("kept", [0.0, 0.5, 0.99])
def test_a_cut_off_file(dataset: Path, name: str, kept: float) -> None:
    content = (dataset / name).read_bytes()
    (dataset / name).write_bytes(content[: int(kept * len(content))])
    for reader in (check_dataset, read_dataset):
        with pytest.raises(DataError, match=r"cut-off .*file-000.parquet") as caught:
            reader(dataset)
        assert "\n" not in str(caught.value)


def test_episodes_and_rows_that_do_not_add_up(dataset: Path) -> None:
    whole = pq.read_table(dataset / DATA)
    pq.write_table(whole.slice(0, 40), dataset / DATA)
    for reader in (check_dataset, read_dataset):
        with pytest.raises(DataError, match="found 40, expected 43"):
            reader(dataset)
    pq.write_table(with_value(whole, "episode_index", 20, 3), dataset / DATA)
    with pytest.raises(DataError, match=r"row 20 .*column episode_index, found 3, expected 1"):
        check_dataset(dataset)
    pq.write_table(with_value(whole, "frame_index", 20, 3), dataset / DATA)
    with pytest.raises(DataError, match=r"row 20 .*column frame_index, found 3, expected 8"):
        check_dataset(dataset)


def test_another_format_version(dataset: Path) -> None:
    edit_info(dataset, lambda info: info.update(codebase_version="v2.1"))
    with pytest.raises(DataError, match=r"by its name alone.*found v2.1, expected v3.0"):
        check_dataset(dataset)


def test_files_that_are_gone(dataset: Path) -> None:
    (dataset / DATA).unlink()
    with pytest.raises(DataError, match="no Parquet files"):
        check_dataset(dataset)
    with pytest.raises(DataError, match="no such dataset"):
        check_dataset(dataset / "absent")


def test_checking_needs_no_lerobot() -> None:
    code = "import sys, lfr.data.checks, lfr.data.windows; assert 'lerobot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
