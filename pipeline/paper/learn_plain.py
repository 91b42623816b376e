"""Stage learn_plain: one method on one transfer, from models of plain demonstrations."""

import sys
from dataclasses import dataclass, field
from typing import Any

from lfr.errors import ParameterError, UnknownNameError
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from lfr.transfer.methods import VARIANTS
from lfr.transfer.methods import method as method_named
from pipeline._stage import unfinished_work
from pipeline.paper._learning import CODE, learn_and_judge
from pipeline.paper._plain import MODELS, POLICIES
from pipeline.paper._plan import learning
from pipeline.paper._runs import paper_run
from pipeline.paper._stage import PARAMS, judging, paper_seeds


@dataclass(frozen=True)
class PlainLearning:
    """Section ``learn_plain``: who learns from plain models too.

    Attributes:
        methods: such as need no variant of a model, since there is none of plain ones.
        rewards: of each method.
        transfer: parameters of `TransferParams` that differ from those of the stage learn.
    """

    methods: tuple[str, ...]
    rewards: tuple[str, ...]
    transfer: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for method in self.methods:
            method_named(method)
            if method in VARIANTS:
                raise ParameterError(f"{method} needs {VARIANTS[method]}, which no plain model is")
        if not self.rewards or "reward" in self.transfer:
            raise ParameterError("the rewards stand in `rewards`, one at least")


def main(transfer: str, method: str) -> None:
    """Run it; the policies go to models/paper-plain-policies/<transfer>-<method>.

    For the seeds of ``questions``. All else but the models, and section ``learn_plain``, is that
    of the stage learn.
    """
    chosen, name = transfer_named(transfer), f"{transfer}-{method}"
    plain, plan = read_section(PlainLearning, "learn_plain", PARAMS), learning()
    if method not in plain.methods:
        raise UnknownNameError("method", method, plain.methods)
    work = unfinished_work("paper-learn-plain", name, code=CODE)
    runs = [
        paper_run(
            chosen, method, seed, plan.params_of(method, reward, plain.transfer), work, MODELS
        )
        for seed in paper_seeds().questions
        for reward in plain.rewards
    ]
    learn_and_judge("learn_plain", name, runs, judging(), POLICIES)


if __name__ == "__main__":
    sys.exit(run_stage(main))
