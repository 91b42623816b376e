"""What cameras cost: one attempt recorded without pictures, and with one, two and three cameras.

    python -m benchmarks.cameras [--repeats 5] [--out results/benchmarks]

The attempt is the same each time: simulated, drawn, encoded as JPEG, logged and synced. Of each
number of cameras: frames per second against none, and frames in a megabyte of the log and of the
dataset that is packed from it. Then pictures per second as they are drawn, without multisampling
and what cannot move only once, against those with MuJoCo's own four samples, and against those
that are drawn as a whole each time. Seconds are the processor's, not the clock's, for a
busy machine distorts them less; one thread draws, in software unless MUJOCO_GL says otherwise.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from benchmarks._datasets import scratch
from benchmarks._figures import FOLDER, Figure, against, show, write
from lfr.data.dataset import pack_dataset
from lfr.data.log_reader import read_log
from lfr.demos.attempt import AttemptParams
from lfr.demos.recorder import AttemptJob, log_path, record_attempt
from lfr.seeds import episode_seed
from lfr.sim import camera
from lfr.sim.camera_params import CameraParams
from lfr.sim.simulation import Simulation

ROBOT, TASK = "panda-joint_position", "lift"
SIZE = 128
NAMES = ("agentview", "wrist", "frontview")
SAMPLES = 4  # MuJoCo's default
PICTURES = 40
MEGABYTE = 2**20


@dataclass(frozen=True)
class Recorded:
    """The attempt's log, how many frames it has and how many were recorded in a second."""

    log: Path
    frames: int
    rate: float


def record(cameras: Sequence[str], folder: Path) -> Recorded:
    """Record the attempt with these cameras."""
    params = tuple(CameraParams(name, SIZE, SIZE) for name in cameras)
    seed = episode_seed("demonstration", 0)
    job = AttemptJob(ROBOT, TASK, seed, str(folder), AttemptParams(), params)
    log = log_path(folder, seed)
    log.unlink(missing_ok=True)
    began = time.process_time()
    made = record_attempt(job)
    seconds = time.process_time() - began
    assert made["success"], "the expert fails from this start; choose another"
    return Recorded(log, made["frames"], made["frames"] / seconds)


def costs(folder: Path, repeats: int) -> list[Figure]:
    """Of one, two and three cameras against none, round by round after one to warm up."""
    sides = [NAMES[:count] for count in range(len(NAMES) + 1)]
    folders = [folder / f"{len(side)}-cameras" for side in sides]
    for each in folders:
        each.mkdir()
    rounds = [
        [record(side, each) for side, each in zip(sides, folders, strict=True)]
        for _ in range(repeats + 1)
    ]
    rates = [[each.rate for each in one] for one in rounds[1:]]
    logs = [each.frames * MEGABYTE / each.log.stat().st_size for each in rounds[-1]]
    datasets = [each.frames * MEGABYTE / packed_size(each.log) for each in rounds[-1]]
    for side, *rate in zip(sides, *rates, strict=True):
        print(f"{'+'.join(side) or 'none'}: {1000 / statistics.median(rate):.2f} ms a frame")
    figures = []
    for unit, rows in (
        ("frames/s", rates), ("frames/MB of log", [logs]), ("frames/MB of dataset", [datasets]),
    ):  # fmt: skip
        for count in range(1, len(sides)):
            name = f"{'+'.join(sides[count])}/none"
            figures.append(against(name, unit, None, [(row[count], row[0]) for row in rows]))
            show(figures[-1])
    return figures


def packed_size(log: Path) -> int:
    """Bytes of the dataset of this one log."""
    out = log.with_suffix("")
    pack_dataset([log], out)
    return sum(file.stat().st_size for file in out.rglob("*") if file.is_file())


def multisampled(model: Any) -> Any:
    """The same visual model, drawn with several samples to a pixel."""
    smooth = copy.copy(model)
    smooth.vis.quality.offsamples = SAMPLES
    return smooth


def whole(model: Any) -> np.ndarray:
    """In the place of `lfr.sim.visual.still`: nothing is drawn ahead of its picture."""
    return np.zeros(model.ngeom, dtype=bool)


def drawing(states: Sequence[np.ndarray], repeats: int) -> list[Figure]:
    """Pictures per second of each camera as they are, against others that cost more."""
    shown, figures = Simulation(ROBOT, TASK), []
    built = camera.visual_model
    others: dict[str, dict[str, Any]] = {
        f"one_sample/{SAMPLES}_samples": {
            "visual_model": lambda *scene: multisampled(built(*scene))
        },
        "drawn_once/each_time": {"still": whole},
    }
    for name, (label, patch) in itertools.product(NAMES, others.items()):
        ours = camera.Camera(ROBOT, TASK, name, SIZE, SIZE)
        with mock.patch.multiple(camera, **patch):
            other = camera.Camera(ROBOT, TASK, name, SIZE, SIZE)
            drawn(other, shown, states[:1])  # which draws what cannot move, if anything
        pairs = []
        for number in range(repeats + 1):
            order = (ours, other) if number % 2 else (other, ours)
            rate = {each: drawn(each, shown, states) for each in order}
            pairs.append((rate[ours], rate[other]))
        figures.append(against(f"{label}: {name}", "pictures/s", None, pairs[1:]))
        show(figures[-1])
        apart = difference(ours, other, shown, states)
        print(f"  the two pictures are {apart:.2f} of 255 apart in the mean", flush=True)
        ours.close()
        other.close()
    return figures


def drawn(by: camera.Camera, shown: Simulation, states: Sequence[np.ndarray]) -> float:
    """Pictures per second."""
    began = time.process_time()
    for state in states:
        shown.set_state(state)
        by.render(shown)
    return len(states) / (time.process_time() - began)


def difference(
    one: camera.Camera, other: camera.Camera, shown: Simulation, states: Sequence[np.ndarray]
) -> float:
    """Mean absolute difference of their pixels, of 255."""
    found = []
    for state in states:
        shown.set_state(state)
        pictures = [each.render(shown).astype(float) for each in (one, other)]
        found.append(np.abs(pictures[0] - pictures[1]).mean())
    return float(np.mean(found))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    with scratch() as folder:
        figures = costs(folder, arguments.repeats)
        states = read_log(next(folder.rglob("*.mcap"))).simulator_state
        chosen = np.linspace(0, len(states) - 1, PICTURES).astype(int)
        figures += drawing(list(states[chosen]), arguments.repeats)
    print(write("cameras", figures, arguments.out))


if __name__ == "__main__":
    main()
