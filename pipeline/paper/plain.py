"""Stage plain: models of one transfer from plain demonstrations, and their zero-shot links."""

import sys

from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from pipeline.paper._choices import PARTS, choices, judge, train
from pipeline.paper._plain import MODELS
from pipeline.paper._stage import judging, paper_seeds, seeds_into


def main(transfer: str) -> None:
    """Train models/paper-plain/<transfer>/seed-<n>/{skills,mapping} and judge their links.

    For the seeds of ``questions``. Each model and each link is made as the stages models and
    zero_shot make theirs; parameters and datasets alone differ.
    """
    chosen = transfer_named(transfer)
    trained = train(chosen, choices(PARTS), paper_seeds().questions, "paper-plain", transfer)
    seeds_into(MODELS / transfer, trained.folders)
    links = judge(chosen, trained.folders, judging().episodes, "paper-plain-links", transfer)
    about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
    found = {"transfer": transfer, **about, "links": links, "runs": trained.runs}
    trained.spent.write("plain", transfer, found)


if __name__ == "__main__":
    sys.exit(run_stage(main))
