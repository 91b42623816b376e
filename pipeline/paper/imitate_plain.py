"""Stage imitate_plain: BC+RNN of the source's plain demonstrations, judged on the target."""

import sys
from pathlib import Path

from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from pipeline.paper._imitation import imitate
from pipeline.paper._plain import DATASETS
from pipeline.paper._stage import paper_seeds

IMITATORS = Path("models/paper-plain-imitators")


def main(transfer: str) -> None:
    """Train models/paper-plain-imitators/<transfer>/seed-<n> and judge them on both arms.

    For the seeds of ``questions``. All but the demonstrations is that of the stage imitate.
    """
    chosen, seeds = transfer_named(transfer), paper_seeds().questions
    imitate("imitate_plain", chosen, DATASETS, seeds, IMITATORS)


if __name__ == "__main__":
    sys.exit(run_stage(main))
