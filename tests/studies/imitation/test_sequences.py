"""Sequences against a loop over frames, and their actions against `lfr.data.windows.Windows`."""

import pytest
import torch

from lfr.data.windows import Windows
from studies.imitation.sequences import Sequences
from tests.studies.imitation.made_up import demonstrations


def test_one_starts_at_every_frame_and_repeats_the_last_of_its_episode() -> None:
    lengths, length = (5, 2, 9), 4
    recorded = demonstrations(lengths)
    batch = Sequences(recorded, length).gather(torch.arange(len(recorded)))
    expected_observations, expected_actions, first = [], [], 0
    for count in lengths:
        for start in range(count):
            rows = [first + min(start + t, count - 1) for t in range(length)]
            expected_observations.append(torch.stack([recorded.observations[r] for r in rows]))
            expected_actions.append(torch.stack([recorded.actions[r] for r in rows]))
        first += count
    assert torch.equal(batch.observations, torch.stack(expected_observations))
    assert torch.equal(batch.actions, torch.stack(expected_actions))


def test_actions_are_those_of_padded_windows() -> None:
    recorded = demonstrations((7, 3, 12))
    sequences, windows = Sequences(recorded, 5), Windows(recorded, 5, padded=True)
    assert len(sequences) == len(windows)
    index = torch.tensor([0, 6, 9, 21, 6])
    found, expected = sequences.gather(index), windows.gather(index)
    assert torch.equal(found.actions, expected.actions)
    assert torch.equal(found.observations[:, 0], expected.observations)


def test_no_steps_are_no_sequence() -> None:
    with pytest.raises(ValueError, match="at least one step"):
        Sequences(demonstrations((3,)), 0)
