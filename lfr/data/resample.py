"""Fewer control steps per second than were recorded.

Step k of the lower rate is the frames that begin in its time: those from ceil(k r) on and before
ceil((k + 1) r), where r is the ratio of the rates. What is observed is what was at its first frame.
A dimension of the action that is a change or a speed becomes the mean over its frames, so that
repeating it for as many frames leads as far; any other one, such as a position or a gripper's
command, its last value.

    frames    | 0 1 2 | 3 4 5 | 6 7 8 | 9 10 11 | 12 13 ...     80 Hz
    steps     |   0   |   1   |   2   |    3    |      ...     25 Hz, r = 3.2
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import torch
from torch import Tensor

from lfr.data.windows import DemonstrationSet

EDGE = 1e-9  # of a frame: rounding of the ratio puts no frame into another step


def first_frame(step: int, ratio: float) -> int:
    """The frame with which a step begins, both counted from the episode's start."""
    return ceil(step * ratio - EDGE)


def frames_of(step: int, ratio: float) -> int:
    """How many frames a step lasts."""
    return first_frame(step + 1, ratio) - first_frame(step, ratio)


def resampled(
    demonstrations: DemonstrationSet, fps: float, deltas: Sequence[str]
) -> DemonstrationSet:
    """The same episodes at ``fps`` control steps a second.

    A reward becomes the sum over a step's frames, a success that of any. The last step of an
    episode may be cut short.

    Args:
        deltas: dimensions of the action that are changes or speeds.

    Raises:
        ValueError: the rate is above the recorded one, or the action has no such dimension.
    """
    ratio = demonstrations.fps / fps
    names = demonstrations.action_space.names
    if ratio < 1.0:
        raise ValueError(f"recorded at {demonstrations.fps:g} a second, so not at {fps:g}")
    if lost := [one for one in deltas if one not in names]:
        raise ValueError(f"deltas: no {', '.join(lost)} in the action's {', '.join(names)}")
    lengths = demonstrations.lengths.tolist()
    counts = [_steps(length, ratio) for length in lengths]
    begins = demonstrations.starts[:-1].tolist()
    first = torch.tensor(
        [begin + first_frame(step, ratio)
         for begin, count in zip(begins, counts, strict=True) for step in range(count)]
    ).long()  # fmt: skip
    ends = torch.cat([first[1:], demonstrations.starts[-1:]])
    step_of = torch.repeat_interleave(torch.arange(len(first)), ends - first)
    averaged = torch.tensor([name in deltas for name in names])

    def summed(values: Tensor) -> Tensor:
        shape = (len(first), *values.shape[1:])
        return torch.zeros(shape, dtype=torch.float64).index_add(0, step_of, values.double())

    mean = summed(demonstrations.actions) / (ends - first)[:, None]
    actions = torch.where(averaged, mean.float(), demonstrations.actions[ends - 1])
    rewards, successes = demonstrations.rewards, demonstrations.successes
    joints = demonstrations.joint_positions
    return replace(
        demonstrations,
        observations=demonstrations.observations[first],
        actions=actions,
        rewards=None if rewards is None else summed(rewards).float(),
        successes=None if successes is None else summed(successes) > 0,
        joint_positions=None if joints is None else joints[first],
        starts=torch.tensor([0, *counts]).cumsum(0),
        fps=fps,
    )


def _steps(frames: int, ratio: float) -> int:
    """How many steps begin in as many frames."""
    count = ceil(frames / ratio)
    return count - (first_frame(count - 1, ratio) >= frames) if count else 0
