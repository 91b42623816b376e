"""Stage recordings: a transfer's learning to look at, drawn from what its runs have left."""

import sys
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.params import read_section
from lfr.program import run_stage
from lfr.progress import progress
from lfr.scenarios import transfer as transfer_named
from lfr.transfer.methods import method as method_named
from lfr.view.learning import save_run
from pipeline._stage import SeedParams


def main(transfer: str, method: str) -> None:
    """Write recordings/<transfer>-<method>/seed-<n>: curves, and episodes of the policies."""
    transfer_named(transfer)
    method_named(method)
    name = f"{transfer}-{method}"
    seeds = read_section(SeedParams, "seeds").transfer
    with write_whole(Path("recordings") / name) as partial:
        for seed in progress(seeds, f"recordings {name}", unit="run"):
            save_run(Path("models/learning") / name / f"seed-{seed}", partial / f"seed-{seed}")


if __name__ == "__main__":
    sys.exit(run_stage(main))
