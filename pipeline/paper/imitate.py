"""Stage imitate: BC+RNN of the source's demonstrations, judged on the target, for every seed."""

import sys

from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from lfr.skills.demonstrations import DATASETS
from pipeline.paper._imitation import imitate
from pipeline.paper._stage import IMITATORS, paper_seeds


def main(transfer: str) -> None:
    """Train models/paper-imitators/<transfer>/seed-<n> and judge them on both arms."""
    imitate("imitate", transfer_named(transfer), DATASETS, paper_seeds().tables, IMITATORS)


if __name__ == "__main__":
    sys.exit(run_stage(main))
