"""One dataset, packed once from made-up logs with images, for all the tests of this folder."""

from pathlib import Path

import pytest

from . import made_up

LENGTHS = (12, 9, 15, 7)
IMAGE_SIZE = 64


@pytest.fixture(scope="session")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return made_up.write_all(tmp_path_factory.mktemp("logs"), LENGTHS, IMAGE_SIZE)


@pytest.fixture(scope="session")
def packed(logs: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Do not write to it: copy it first."""
    from lfr.data.dataset import pack_dataset

    out = tmp_path_factory.mktemp("lerobot") / "panda-lift"
    pack_dataset(logs, out, video=True)
    return out
