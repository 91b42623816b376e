"""Stage learn: one method on one transfer, for every reward and seed, judged on held-out starts."""

import sys

from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from lfr.transfer.methods import method as method_named
from pipeline._stage import unfinished_work
from pipeline.paper._learning import CODE, learn_and_judge
from pipeline.paper._plan import learning
from pipeline.paper._runs import paper_run
from pipeline.paper._stage import POLICIES, judging, paper_seeds


def main(transfer: str, method: str) -> None:
    """Run a method on a transfer; the policies go to models/paper-policies/<transfer>-<method>."""
    chosen, name, plan = transfer_named(transfer), f"{transfer}-{method}", learning()
    method_named(method)
    # A run names its models and parameters itself, so another seed runs its own jobs alone.
    work = unfinished_work("paper-learn", name, code=CODE)
    runs = [
        paper_run(chosen, method, seed, plan.params_of(method, reward), work)
        for seed in plan.seeds_of(method, paper_seeds())
        for reward in plan.rewards_of(method)
    ]
    learn_and_judge("learn", name, runs, judging(), POLICIES)


if __name__ == "__main__":
    sys.exit(run_stage(main))
