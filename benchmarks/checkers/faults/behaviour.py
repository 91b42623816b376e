"""Faults of states and actions, with all that is said of them true: on `arm`, as a robot has it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.checkers.bases import SENSOR
from benchmarks.checkers.dataset_copy import DatasetCopy
from benchmarks.checkers.faults.fault import ROW, Fault, K, Plant

STUCK = (
    "frozen|freeze|stuck|dead|constant|identical|repeat|flat|static|never|not move|no_motion|idle"
    "|same|still|inert|variance|std"
)
LAG = "lag|sync|delay|shift|latency|track|follow|diverg|offset|consisten|come after|mismatch"
SPIKE = "spike|outlier|jump|glitch|discontin|jitter|teleport|velocity|jerk|smooth|far from|anomal"
UNIT = "unit|degree|range|outlier|scale|distribution|shift|spike|bound|consisten|anomal|jump"
NOISE = "jitter|noise|smooth|jerk|hf_|high.?freq|shak|tremor|spike|velocity|ldlj|rough"

DEGREES = 180 / np.pi
Arrays = tuple[NDArray[np.float32], NDArray[np.float32]]
"""States and actions, (N, 8) each."""


def _moved(change: Callable[[NDArray, NDArray], object]) -> Plant:
    """A change of one episode's states and actions, or of views of them."""

    def plant(copy: DatasetCopy) -> None:
        span = copy.span(K)
        edit(copy, lambda states, actions: change(states[span], actions[span]))

    return plant


def _all_moved(change: Callable[[NDArray, NDArray], object]) -> Plant:
    """A change of all states and actions."""
    return lambda copy: edit(copy, change)


def edit(copy: DatasetCopy, change: Callable[[NDArray, NDArray], object]) -> None:
    """Change the (N, 8) states and actions, with statistics to match."""
    keys = ("observation.state", "action")
    values = [copy.values(key) for key in keys]
    change(*values)
    for key, array in zip(keys, values, strict=True):
        copy.put(key, array)
    copy.restat(*keys)


def _hold(first: int, last: int | None, *dimensions: int, of: int = 0) -> Plant:
    """A stretch of an episode's states, or with `of` 1 of its actions, that stays as it begins."""
    chosen = list(dimensions) or slice(None)

    def change(*arrays: NDArray) -> None:
        arrays[of][first:last, chosen] = arrays[of][first, chosen]

    return _moved(change)


def _still_dimension(dimension: int, *of: int, all: bool) -> Plant:
    """A dimension that never changes: of one episode, or of all."""

    def change(*arrays: NDArray) -> None:
        for i in of:
            arrays[i][:, dimension] = arrays[i][0, dimension]

    return _all_moved(change) if all else _moved(change)


def _late(states: NDArray, actions: NDArray) -> None:
    before = np.random.default_rng(len(actions)).normal(0, SENSOR, (10, actions.shape[1]))
    actions[10:] = actions[:-10].copy()
    actions[:10] = actions[10] + before


def _each_late(copy: DatasetCopy) -> None:
    spans = [copy.span(e) for e in range(copy.episodes.num_rows)]
    edit(copy, lambda states, actions: [_late(states[s], actions[s]) for s in spans])


def _spike(deviations: float) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        row = copy.span(K).start + ROW

        def change(states: NDArray, actions: NDArray) -> None:
            column = actions[:, 2]
            column[row] = column.mean() + deviations * column.std()

        edit(copy, change)

    return plant


def _add(of: int, where: object, by: float | NDArray) -> Plant:
    return _moved(lambda *arrays: np.add.at(arrays[of], where, by))  # type: ignore[arg-type]


def _scale(where: object, by: float, *of: int) -> Callable[[NDArray, NDArray], object]:
    def change(*arrays: NDArray) -> None:
        for i in of:
            arrays[i][where] *= by  # type: ignore[index]

    return change


def _trembling(of: int, by: float) -> Plant:
    def change(*arrays: NDArray) -> None:
        arrays[of][:] += np.random.default_rng(0).normal(0, by, arrays[of].shape)

    return _moved(change)


def _swapped(states: NDArray, actions: NDArray) -> None:
    states[:, [0, 1]] = states[:, [1, 0]]


def _wrapped(states: NDArray, actions: NDArray) -> None:
    states[:, 6] %= np.float32(2 * np.pi)
    states[60:, 6] -= np.float32(2 * np.pi)


def _saturated(copy: DatasetCopy) -> None:
    span = copy.span(K)

    def change(states: NDArray, actions: NDArray) -> None:
        most = actions[:, 3].min() + np.float32(0.05)
        actions[span, 3] = np.minimum(actions[span, 3], most)

    edit(copy, change)


def _random(copy: DatasetCopy) -> None:
    span, rng = copy.span(K), np.random.default_rng(0)

    def change(states: NDArray, actions: NDArray) -> None:
        low, high = actions.min(axis=0), actions.max(axis=0)
        actions[span] = rng.uniform(low, high, actions[span].shape)

    edit(copy, change)


def _half_rate(copy: DatasetCopy) -> None:
    """Every second row repeats the one before."""

    def change(*arrays: NDArray) -> None:
        frame = copy.values("frame_index")
        rows = np.arange(len(frame)) - frame % 2
        for array in arrays:
            array[:] = array[rows]

    edit(copy, change)


ARM = np.s_[:, :7]


def on_arm(plant: Plant, fits: str) -> Fault:
    """A fault of what an arm did."""
    return Fault("behaviour", plant, fits, "arm")


FAULTS = {
    "state_stuck_2s": on_arm(_hold(40, 80), STUCK),
    "one_joint_stuck_2s": on_arm(_hold(40, 80, 3), STUCK),
    "state_stuck_episode": on_arm(_hold(0, None), STUCK),
    "one_joint_dead_episode": on_arm(_hold(0, None, 3), STUCK),
    "one_joint_dead_all": on_arm(_still_dimension(3, 0, all=True), STUCK),
    "action_constant_episode": on_arm(_hold(0, None, of=1), STUCK),
    "action_zero_episode": on_arm(_moved(lambda s, a: a.fill(0)), STUCK),
    "gripper_still_episode": on_arm(_still_dimension(7, 0, 1, all=False), f"{STUCK}|gripper"),
    "gripper_still_all": on_arm(_still_dimension(7, 0, 1, all=True), f"{STUCK}|gripper"),
    "action_lag_10_episode": on_arm(_moved(_late), LAG),
    "action_lag_10_all": on_arm(_each_late, LAG),
    "action_spike_50_sigma": on_arm(_spike(50), SPIKE),
    "action_spike_8_sigma": on_arm(_spike(8), SPIKE),
    "state_spike_one_frame": on_arm(_add(0, (ROW, 2), 0.8), SPIKE),
    "joint_teleport": on_arm(_add(0, np.s_[60:, 3], 0.8), f"{SPIKE}|{LAG}"),
    "joint_wraps": on_arm(_moved(_wrapped), f"{SPIKE}|wrap"),
    "one_episode_in_degrees": on_arm(_moved(_scale(ARM, DEGREES, 0, 1)), UNIT),
    "one_state_in_degrees": on_arm(_moved(_scale(ARM, DEGREES, 0)), f"{UNIT}|{LAG}"),
    "state_degrees_action_radians": on_arm(_all_moved(_scale(ARM, DEGREES, 0)), f"{UNIT}|{LAG}"),
    "joint_sign_flipped_episode": on_arm(_moved(_scale(np.s_[:, 1], -1, 0)), f"{LAG}|sign|outlier"),
    "joints_swapped_episode": on_arm(_moved(_swapped), f"{LAG}|order"),
    "state_noise_episode": on_arm(_trembling(0, 0.03), NOISE),
    "action_noise_episode": on_arm(_trembling(1, 0.1), NOISE),
    "action_saturated_episode": on_arm(_saturated, "satur|clip|limit|bound|pinned"),
    "action_random_episode": on_arm(_random, f"{NOISE}|{SPIKE}|{LAG}"),
    "action_offset_episode": on_arm(_add(1, np.s_[:], 0.15), f"{LAG}|calibrat|bias|beside"),
    "action_copied_from_state": on_arm(
        _all_moved(lambda s, a: np.copyto(a, s)), "cop(y|ied)|identical|same|equal|leak|the state"
    ),
    "recorded_at_10_hz": on_arm(_half_rate, f"fps|rate|time|sampl|cadence|dup|{STUCK}"),
}  # fmt: skip
