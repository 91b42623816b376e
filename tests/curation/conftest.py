"""One sound dataset with videos and its logs, packed once, for all the tests of this folder."""

import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from . import arm, made_up
from .broken import EPISODES, TASKS

LENGTHS = (12, 9, 15, 7, 12)
IMAGE_SIZE = 64


@pytest.fixture(scope="session")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`data/lerobot/panda-lift` beside `data/logs/panda-lift`. Copy it before you write to it."""
    from lfr.data.dataset import pack_dataset

    data = tmp_path_factory.mktemp("sound") / "data"
    logs = made_up.write_all(data / "logs" / "panda-lift", LENGTHS, IMAGE_SIZE)
    pack_dataset(logs, data / "lerobot" / "panda-lift", video=True)
    return data / "lerobot" / "panda-lift"


@pytest.fixture
def dataset(sound: Path, tmp_path: Path) -> Path:
    """A copy to be broken, its logs beside it."""
    shutil.copytree(sound.parent.parent, tmp_path / "data")
    return tmp_path / "data/lerobot/panda-lift"


@pytest.fixture(scope="session")
def by_lerobot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset that owes nothing to this project: other names, recorded with LeRobot's own API."""
    return made_up.record_with_lerobot(tmp_path_factory.mktemp("theirs") / "reach")


HOSTILE = "<script>alert(1)</script>\x1b[31m @someone `x` | y \"'"
"""A task's words that are out to do harm."""


@pytest.fixture(scope="session")
def several(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seventeen episodes with findings: 7 with a stuck joint, 16 the same as 7, hostile words."""
    from .test_behaviour import FAULTS, twice

    of = arm.recording()
    FAULTS["a joint is stuck"][0](of)
    twice(of)
    path = arm.write(tmp_path_factory.mktemp("several") / "arm", of)
    for file, column in ((TASKS, "task"), (EPISODES, "tasks")):
        table = pq.read_table(path / file)
        words = [HOSTILE if column == "task" else [HOSTILE]] * len(table)
        at = table.column_names.index(column)
        pq.write_table(table.set_column(at, column, [words]), path / file)
    return path
