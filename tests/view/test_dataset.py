"""A dataset's episode, read without LeRobot, against the log that it was packed from."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lfr.data.dataset import pack_dataset
from lfr.errors import DataError
from lfr.view.dataset import find_log, read_episode

from .conftest import FRAMES, Recorded


@pytest.fixture(scope="module")
def packed(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("lerobot") / "panda-lift"
    pack_dataset([recorded.log], out, video=True)
    return out


def test_its_features_are_those_of_the_log(packed: Path, recorded: Recorded) -> None:
    episode = read_episode(packed, 0)
    assert (episode.robot, episode.task, episode.seed) == ("panda", "lift", 5)
    for key, column in recorded.episode.features.items():
        np.testing.assert_array_equal(episode.features[key], column, err_msg=key)
    assert episode.schema["action"].names == recorded.episode.schema["action"].names


def test_its_video_has_the_logs_images(packed: Path) -> None:
    files = read_episode(packed, 0).images["agentview"]
    means = [np.asarray(Image.open(io.BytesIO(file))).mean() for file in files]
    np.testing.assert_allclose(means, 20.0 * np.arange(FRAMES), atol=6)


def test_the_log_is_found_while_it_is_unchanged(packed: Path, recorded: Recorded) -> None:
    episode = read_episode(packed, 0)
    place = packed.parent.parent / "logs" / packed.name / recorded.log.name
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(recorded.log.read_bytes())
    assert find_log(packed, episode) is not None
    place.write_bytes(b"another")
    found = find_log(packed, episode)
    assert found is None or found.resolve() != place.resolve()


def test_an_episode_that_is_not_there(packed: Path) -> None:
    with pytest.raises(DataError, match=r"episode 7.*0 to 0"):
        read_episode(packed, 7)
