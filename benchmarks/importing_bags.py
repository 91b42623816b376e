"""The most memory that `lfr import` takes of ROS 2 bags, from small ones to large ones.

    python -m benchmarks.importing_bags [--gigabytes 0.25 0.5] [--fps 5] [--out results/benchmarks]

The bags have two cameras of 640 x 480 in JPEG, joint states at 100 Hz and a gripper. Each is
imported by a process of its own, which is all there is: it has no child. What counts is VmHWM, the
most that the process has had in main memory, libraries included, from its start to its end. So a
busy machine does no harm, but for the time; Linux alone says it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks._bags import MAPPING, write_bag
from benchmarks._datasets import scratch
from benchmarks._figures import FOLDER, Figure, show, within, write
from lfr.artifacts import read_json

LIMIT, GROWTH = 1024, 64  # MiB: of any bag, and from the smallest to the largest

# `lfr`, and then what it took.
LFR = """
import json, resource, sys
from pathlib import Path
from lfr.cli import main

code = main(sys.argv[1:])
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps([int(status["VmHWM"].split()[0]) / 1024, children / 1024]))
sys.exit(code)
"""


def peak_of_import(bag: Path, mapping: Path, dataset: Path) -> float:
    """MiB: the most that importing a bag takes in main memory.

    Raises:
        RuntimeError: the import fails, or starts another process.
    """
    command = [sys.executable, "-c", LFR, "import", str(bag)]
    done = subprocess.run([*command, "--mapping", str(mapping), "--to", str(dataset)],
                          capture_output=True, text=True)  # fmt: skip
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    peak, children = json.loads(done.stdout.splitlines()[-1])
    if children:
        raise RuntimeError(f"another process, of {children} MiB, is not counted")
    return peak


def measure(gigabytes: float, fps: int, folder: Path) -> tuple[Figure, dict[str, Any]]:
    """The figure of one size, printed, and what the bag and its dataset hold."""
    bag, mapping, dataset = folder / "take.mcap", folder / "mapping.yaml", folder / "dataset"
    mapping.write_text(MAPPING.format(fps=fps), encoding="utf-8")
    written = write_bag(bag, round(gigabytes * 1e9))
    began = time.perf_counter()
    peak = peak_of_import(bag, mapping, dataset)
    took = time.perf_counter() - began
    figure = within(f"peak/{gigabytes:g}-GB", "MiB", LIMIT, [peak])
    show(figure)
    info = read_json(dataset / "meta" / "info.json")
    holds = {name: info[name] for name in ("total_episodes", "total_frames", "fps")}
    return figure, {**asdict(written), **holds, "import_seconds": round(took)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gigabytes", type=float, nargs="+", default=[0.25, 0.5])
    parser.add_argument("--fps", type=int, default=5)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    figures, bags = [], {}
    for gigabytes in sorted(arguments.gigabytes):
        with scratch() as folder:
            figure, bags[f"{gigabytes:g}-GB"] = measure(gigabytes, arguments.fps, folder)
        figures.append(figure)
    if len(figures) > 1:
        growth = max(0.0, figures[-1].ours - figures[0].ours)
        figures.append(within("growth", "MiB", GROWTH, [growth]))
        show(figures[-1])
    print(write("importing_bags", figures, arguments.out, {"bags": bags}))


if __name__ == "__main__":
    main()
