"""Seconds to verify a large dataset on one core, against the minute it may take.

    python -m benchmarks.datasets [--episodes 10000] [--repeats 3] [--out results/benchmarks]

The dataset is made up, of states alone, in the layout that packing writes: one row group and a
full set of statistics for each episode. Every check of `lfr verify` runs, and must find nothing.
Times are the process's own, which what else the machine does falsifies least.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import pyarrow as pa

from benchmarks._datasets import Size, write_dataset
from benchmarks._figures import FOLDER, Figure, show, within, write
from lfr.curation.verify import verify_dataset

SECONDS_GOAL = 60.0  # for 10,000 episodes


def verifying(episodes: int, repeats: int) -> Figure:
    """Seconds for all checks, the dataset's files in the page cache."""
    seconds = []
    with tempfile.TemporaryDirectory(prefix="lfr-bench-") as folder:
        path = Path(folder) / "made-up"
        rows = write_dataset(path, Size(episodes))
        print(f"{episodes} episodes, {rows} rows", flush=True)
        for _ in range(repeats):
            began = time.process_time()
            report = verify_dataset(path)
            seconds.append(time.process_time() - began)
            assert not report.findings, report.findings
    return within(f"verify/{episodes}_episodes", "s", SECONDS_GOAL, seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=10_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    pa.set_cpu_count(1)
    figures = [verifying(arguments.episodes, arguments.repeats)]
    for figure in figures:
        show(figure)
    print(write("datasets", figures, arguments.out))


if __name__ == "__main__":
    main()
