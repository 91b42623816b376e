"""Windows of H actions per second: gathered from tensors, and read by LeRobotDataset.

    python -m benchmarks.windows [--episodes 1000] [--repeats 3] [--out results/benchmarks]

The same windows on both sides, which is checked first: a row's observation and the H actions from
it on, `skills.vae.horizon` of them, of rows drawn at random from a made-up dataset of states alone.
LeRobot's are asked for with `delta_timestamps`, once one after the other by `__getitem__`, not even
put together to batches, and once through PyTorch's DataLoader with two workers, as `lerobot-train`
sets it up. Each brings its row's other columns too; no option leaves them out. Ours are drawn and
gathered on one thread, in batches of the size that the VAE is trained with (`skills.vae.batch`) and
in larger ones. Reading the dataset counts on neither side. `getitem` counts the process's own time;
`dataloader` counts the wall clock, so it needs a quiet machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import torch
from torch.utils.data import DataLoader, RandomSampler

from benchmarks._datasets import Size, scratch, write_dataset
from benchmarks._figures import FOLDER, Figure, Measurement, compare, show, write
from lfr.data.episode import ACTION, ENVIRONMENT_STATE, FPS, STATE
from lfr.data.windows import Windows, read_dataset
from lfr.params import read_section
from lfr.skills.skill_params import SkillsParams

if TYPE_CHECKING:
    from lerobot.datasets import LeRobotDataset

RATIO_GOAL = 1000.0
LARGE = 512  # windows in a larger batch
GATHERED, READ = 200_000, 256  # windows timed at a time, ours and by `__getitem__`
WORKERS, TIMED = 2, 2  # of the DataLoader; batches of each worker that are timed, after its first

Clock = Callable[[], float]


def gathered(windows: Windows, batch: int, clock: Clock) -> Measurement:
    """Windows per second in random batches, the draw included."""
    generator = torch.Generator().manual_seed(0)
    rounds = max(GATHERED // batch, 1)

    def measure() -> float:
        began = clock()
        for _ in range(rounds):
            windows.gather(torch.randint(len(windows), (batch,), generator=generator))
        return rounds * batch / (clock() - began)

    return measure


def one_by_one(dataset: LeRobotDataset) -> Measurement:
    """Windows per second of `__getitem__`, in this process."""
    generator = torch.Generator().manual_seed(0)

    def measure() -> float:
        index = torch.randint(len(dataset), (READ,), generator=generator).tolist()
        began = time.process_time()
        for i in index:
            dataset[i]
        return READ / (time.process_time() - began)

    return measure


def by_workers(dataset: LeRobotDataset, batch: int) -> Measurement:
    """Windows per second of a DataLoader whose workers stay from one measurement to the next.

    The clock starts when each worker has handed in its first batch, so both are at work, and ends
    with the last batch of a sampler that holds no more: in between measurements they rest.
    """
    count = batch * WORKERS * (1 + TIMED)
    sampler = RandomSampler(dataset, replacement=True, num_samples=count)
    loader = DataLoader(
        dataset, batch, sampler=sampler, num_workers=WORKERS, persistent_workers=True,
        multiprocessing_context="spawn",
    )  # fmt: skip

    def measure() -> float:
        arriving = iter(loader)
        for _ in range(WORKERS):
            next(arriving)
        began = time.perf_counter()
        seen = sum(len(each[ACTION]) for each in arriving)
        return seen / (time.perf_counter() - began)

    return measure


def check_same(windows: Windows, dataset: LeRobotDataset, sample: int = 50) -> None:
    """Compare windows drawn at random, and the last, which is padded, value by value."""
    assert len(windows) == len(dataset)
    drawn = torch.randint(len(dataset), (sample,), generator=torch.Generator().manual_seed(0))
    index = [*drawn.tolist(), len(dataset) - 1]
    batch = windows.gather(torch.tensor(index))
    for place, number in enumerate(index):
        row = dataset[number]
        pairs = {
            "observation": (batch.observations, torch.cat([row[STATE], row[ENVIRONMENT_STATE]])),
            ACTION: (batch.actions, row[ACTION]),
            "padding": (batch.is_pad, row[f"{ACTION}_is_pad"]),
        }
        for name, (ours, theirs) in pairs.items():
            assert torch.equal(ours[place], theirs), f"window {number}: another {name}"


def measure(path: Path, horizon: int, batches: tuple[int, ...], repeats: int) -> list[Figure]:
    """All figures of the dataset at `path`, each printed as soon as it is known."""
    from lerobot.datasets import LeRobotDataset

    windows = Windows(read_dataset(path), horizon, padded=True)
    dataset = LeRobotDataset(
        f"lfr/{path.name}", path, delta_timestamps={ACTION: [t / FPS for t in range(horizon)]},
        video_backend="pyav",
    )  # fmt: skip
    check_same(windows, dataset)
    figures = []
    for batch in batches:
        sides = {
            "getitem": (time.process_time, one_by_one(dataset)),
            f"dataloader_{WORKERS}_workers": (time.perf_counter, by_workers(dataset, batch)),
        }
        for name, (clock, theirs) in sides.items():
            ours, label = gathered(windows, batch, clock), f"{name}/batch_{batch}"
            figures.append(compare(label, "windows/s", RATIO_GOAL, ours, theirs, repeats))
            show(figures[-1])
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    vae = read_section(SkillsParams, "skills").vae
    with scratch() as folder:
        path = folder / "panda-lift"
        rows = write_dataset(path, Size(arguments.episodes))
        print(f"{arguments.episodes} episodes, {rows} rows", flush=True)
        figures = measure(path, vae.horizon, (vae.batch, LARGE), arguments.repeats)
    print(write("windows", figures, arguments.out))


if __name__ == "__main__":
    main()
