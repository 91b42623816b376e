"""Windows equal what LeRobotDataset returns with delta_timestamps, and a loop over the rows."""

from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lfr.columns import ActionSpace
from lfr.data.log_reader import read_log
from lfr.data.windows import DemonstrationSet, Windows, read_dataset
from lfr.errors import DataError

from . import made_up
from .conftest import LENGTHS


def demonstrations(lengths: list[int]) -> DemonstrationSet:
    """Row r has the action [r] and the observation [r, -r]."""
    rows = torch.arange(sum(lengths), dtype=torch.float32)
    return DemonstrationSet(
        observations=torch.stack([rows, -rows], dim=1),
        actions=rows[:, None],
        rewards=rows,
        successes=rows > 0,
        starts=torch.tensor([0, *np.cumsum(lengths)]),
        observation_names=("a", "b"),
        action_space=ActionSpace(("c",), (-1.0,), (1.0,)),
        robot="panda",
        task="lift",
        fps=20,
        seeds=tuple(range(100, 100 + len(lengths))),
    )


def test_the_rows_are_the_logs(packed: Path, logs: list[Path]) -> None:
    found = read_dataset(packed)
    episodes = [read_log(log).features for log in logs]
    keys = ("observation.state", "observation.environment_state")
    observations = np.concatenate([np.hstack([e[key] for key in keys]) for e in episodes])
    np.testing.assert_array_equal(found.observations, observations)
    for values, key in (
        (found.actions, "action"),
        (found.rewards, "next.reward"),
        (found.successes, "next.success"),
    ):
        np.testing.assert_array_equal(values, np.concatenate([e[key] for e in episodes]))
    assert found.lengths.tolist() == list(LENGTHS)
    assert found.observation_names == made_up.STATE_NAMES + made_up.ENVIRONMENT_NAMES
    assert found.action_space.names[-1] == "gripper"
    assert (found.robot, found.task, found.fps) == ("panda", "lift", 20)
    assert found.seeds == (0, 1, 2, 3)


@pytest.mark.parametrize("horizon", [1, 10, 16])  # 16: longer than every episode
def test_padded_windows_are_lerobots(packed: Path, horizon: int) -> None:
    from lerobot.datasets import LeRobotDataset

    oracle = LeRobotDataset(
        "lfr/panda-lift",
        root=packed,
        delta_timestamps={"action": [i / 20 for i in range(horizon)]},
        video_backend="pyav",
    )
    oracle.meta.info.features.pop("observation.images.agentview")  # no need to decode the video
    batch = Windows(read_dataset(packed), horizon, padded=True).all()
    assert len(batch.actions) == len(oracle) == sum(LENGTHS)
    for i in range(len(oracle)):
        row = oracle[i]
        observation = torch.cat([row["observation.state"], row["observation.environment_state"]])
        assert torch.equal(batch.observations[i], observation)
        assert torch.equal(batch.actions[i], row["action"].reshape(horizon, 7))
        assert torch.equal(batch.is_pad[i], row["action_is_pad"])


@settings(max_examples=60)
@given(
    lengths=st.lists(st.integers(1, 12), min_size=1, max_size=6),
    horizon=st.integers(1, 15),
    padded=st.booleans(),
)
def test_windows_are_those_of_a_loop(lengths: list[int], horizon: int, padded: bool) -> None:
    expected, first = [], 0
    for length in lengths:
        for t in range(length):
            if padded or t + horizon <= length:
                actions = [first + min(t + h, length - 1) for h in range(horizon)]
                expected.append((first + t, actions, [t + h >= length for h in range(horizon)]))
        first += length
    windows = Windows(demonstrations(lengths), horizon, padded=padded)
    batch = windows.all()
    assert len(windows) == len(expected)
    assert batch.actions.shape == (len(expected), horizon, 1)
    for i, (start, actions, is_pad) in enumerate(expected):
        assert batch.observations[i].tolist() == [start, -start]
        assert batch.actions[i, :, 0].tolist() == actions
        assert batch.is_pad[i].tolist() == is_pad


def test_gather_takes_windows_by_their_number() -> None:
    windows = Windows(demonstrations([4, 5]), 3, padded=False)
    index = torch.tensor([4, 0, 4])
    some, every = windows.gather(index), windows.all()
    for a, b in zip(some, every, strict=True):
        assert torch.equal(a, b[index])
    with pytest.raises(ValueError, match="horizon of 0"):
        Windows(demonstrations([4]), 0, padded=True)


@settings(max_examples=60)
@given(
    lengths=st.lists(st.integers(1, 4), min_size=1, max_size=30),
    held_out=st.floats(0, 1, exclude_max=True),
    seed=st.integers(0, 2**32),
)
def test_the_split_is_by_episode(lengths: list[int], held_out: float, seed: int) -> None:
    whole = demonstrations(lengths)
    train, test = whole.split(held_out, seed)
    assert sorted(train.seeds + test.seeds) == list(whole.seeds)
    assert len(train) + len(test) == len(whole)
    assert train.episodes >= 1
    assert (test.episodes > 0) == (held_out > 0 and len(lengths) > 1)
    assert abs(test.episodes - held_out * len(lengths)) <= 1
    for part in (train, test):  # every episode whole and under its own seed
        for e, number in enumerate(part.seeds):
            rows = part.observations[part.starts[e] : part.starts[e + 1], 0]
            first = int(whole.starts[number - 100])
            assert rows.tolist() == list(range(first, first + lengths[number - 100]))
    again = whole.split(held_out, seed)[1]
    assert again.seeds == test.seeds


def test_another_seed_is_another_split() -> None:
    whole = demonstrations([3] * 50)
    assert len({whole.split(0.2, seed)[1].seeds for seed in range(5)}) == 5
    with pytest.raises(ValueError, match=r"found 1\.5"):
        whole.split(1.5, 0)


def test_there_must_be_a_dataset(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such dataset"):
        read_dataset(tmp_path / "absent")
    with pytest.raises(DataError, match="not a LeRobot dataset"):
        read_dataset(tmp_path)
