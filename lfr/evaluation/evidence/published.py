"""What the paper reports: Yang, Stork and Stoyanov, "Learn from Robot", Tables I to III.

Success in percent, mean and standard deviation of 3 tests of 10 trials each (part V.B). The paper's
columns "No Generator", "Dataset Lift" and "Dataset Nut-Assembly" are no_generator, only_lift and
only_nut_assembly here; "Ours" is lfr, and stands beside these in our Table III.
"""

from __future__ import annotations

from dataclasses import dataclass

from lfr.evaluation.evidence.aggregate import Interval
from lfr.evaluation.statistics import wilson_interval

TRIALS = 30  # 3 tests of 10


@dataclass(frozen=True)
class Published:
    """A cell of the paper's tables, in percent."""

    rate: float
    deviation: float

    @property
    def interval(self) -> Interval:
        """Wilson's, of the trials that it is the mean of."""
        rate = self.rate / 100
        return Interval(rate, *wilson_interval(round(rate * TRIALS), TRIALS))

    def __str__(self) -> str:
        return f"{self.rate:.1f} ± {self.deviation:.1f}"


@dataclass(frozen=True)
class PaperTable:
    """Which transfers and methods a table has, in the paper's order.

    Attributes:
        about: what is compared, in a few words.
    """

    name: str
    about: str
    transfers: tuple[str, ...]
    methods: tuple[str, ...]


TASKS = {
    "s1-panda-lift": "Lift, Panda",
    "s1-sawyer-stack": "Stack, Sawyer",
    "s2-panda-stack": "Stack, Panda",
    "s2-sawyer-pick_place": "Pick-Place, Sawyer",
}
BASELINES = ("bc_rnn", "ap", "sac")
ABLATIONS = ("no_generator", "only_lift", "only_nut_assembly")
SCENARIO_1, SCENARIO_2 = tuple(TASKS)[:2], tuple(TASKS)[2:]

TABLES = {
    "table1": PaperTable("Table I", "scenario 1", SCENARIO_1, (*BASELINES, "lfr")),
    "table2": PaperTable("Table II", "scenario 2", SCENARIO_2, (*BASELINES, "lfr")),
    "table3": PaperTable("Table III", "ablations", SCENARIO_2, (*ABLATIONS, "lfr")),
}

_ROWS = {
    ("s1-panda-lift", (*BASELINES, "lfr")): ((42.0, 2.2), (56.6, 1.4), (89.0, 0.2), (98.0, 0.6)),
    ("s1-sawyer-stack", (*BASELINES, "lfr")): ((36.0, 1.0), (58.0, 0.6), (40.5, 3.2), (92.0, 0.7)),
    ("s2-panda-stack", (*BASELINES, "lfr")): ((42.8, 1.5), (37.0, 3.5), (30.2, 2.5), (90.2, 1.7)),
    ("s2-sawyer-pick_place", (*BASELINES, "lfr")): (
        (16.3, 4.4), (10.6, 5.7), (0.0, 0.0), (82.5, 3.2),
    ),
    ("s2-panda-stack", ABLATIONS): ((5.0, 1.6), (67.8, 2.2), (87.6, 1.8)),
    ("s2-sawyer-pick_place", ABLATIONS): ((3.5, 1.2), (42.4, 3.2), (76.0, 2.5)),
}  # fmt: skip

PUBLISHED: dict[tuple[str, str], Published] = {
    (transfer, method): Published(*cell)
    for (transfer, methods), cells in _ROWS.items()
    for method, cell in zip(methods, cells, strict=True)
}
"""(transfer, method) -> cell."""
