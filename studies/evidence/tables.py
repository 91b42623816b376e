"""The tables of docs/evidence.md, from the table of all runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from lfr.evaluation.names import NAMES, PAPER
from lfr.evaluation.results_tables import markdown, percent
from studies.evidence.evidence_params import OURS
from studies.evidence.runs import Run
from studies.evidence.statistics import Interval, Outcomes, difference, outcomes_of, success

PAPERS = ("s1-panda-joint_position-lift", "s1-sawyer-joint_position-stack",
          "s2-panda-joint_position-stack", "s2-sawyer-joint_position-pick_place")  # fmt: skip
"""The paper's transfers, in joint space."""

CHAIN = ("own_arm", "identity", "no_generator", "linear", "lfr", "recoded", "retarget", "oracle")


@dataclass(frozen=True)
class Chosen:
    """Some of the runs, and how they did.

    Attributes:
        runs: of one policy, a seed each, in their order.
    """

    runs: tuple[Run, ...]

    @property
    def outcomes(self) -> Outcomes:
        return outcomes_of([run.outcomes for run in self.runs])

    @property
    def interval(self) -> Interval:
        return success(self.outcomes)

    @property
    def seeds(self) -> tuple[int, ...]:
        return tuple(run.seed for run in self.runs)

    def of_seeds(self, seeds: Iterable[int]) -> Chosen:
        wanted = set(seeds)
        return Chosen(tuple(run for run in self.runs if run.seed in wanted))


def chosen(
    runs: Iterable[Run], transfer: str, method: str, *, learned: bool = False,
    option: str | None = None, reward: str = "sparse", demonstrations: int = 50,
    judge: str = "engine",
) -> Chosen:  # fmt: skip
    """One policy's runs, by seed.

    Args:
        learned: after learning on the target, with this reward; else before.
        option: of the mapping; None is this project's own.
    """
    with_g = method in ("lfr", "linear")
    wanted = (transfer, method, (option or OURS) if with_g else "",
              reward if learned else "", demonstrations, judge)  # fmt: skip
    found = [
        run
        for run in runs
        if (run.transfer, run.method, run.option, run.reward, run.demonstrations, run.judge)
        == wanted
    ]
    return Chosen(tuple(sorted(found, key=lambda run: run.seed)))


def rate(found: Chosen) -> str:
    """``92 (85-96)``, or a dash where nothing was run."""
    if not found.runs:
        return "-"
    mean, low, high = found.interval
    return percent(mean, (low, high))


def above(first: Chosen, second: Chosen) -> str:
    """``+12 (8 to 16)`` points that the first is above the second, over the seeds of both."""
    if not (first.runs and second.runs):
        return "-"
    seeds = set(first.seeds) & set(second.seeds)
    both = (one.of_seeds(seeds).outcomes for one in (first, second))
    mean, low, high = (round(100 * value) for value in difference(*both))
    return f"{mean:+d} ({low:+d} to {high:+d})"


def task_and_target(run: Run) -> str:
    """``Stack, Panda``."""
    return f"{NAMES[run.task]}, {NAMES[run.target]}"


LEARNERS = ("ap", "sac", "spirl", "no_generator", "retarget")


def methods_table(runs: Sequence[Run], reward: str = "sparse") -> str:
    """Tables I and II: every method on the paper's transfers, and the paper's own figures below.

    A method that has not been run has no column.
    """
    columns = ["bc_rnn", *LEARNERS]
    header = ["task", "seeds", "LfR, before", "LfR, after", "robosuite",
              *map(NAMES.__getitem__, columns)]  # fmt: skip
    found: list[tuple[Run, list[Chosen]]] = []
    for transfer in PAPERS:
        before = chosen(runs, transfer, "lfr")
        if before.runs:
            after, stock = (
                chosen(runs, transfer, "lfr", learned=True, reward=reward, judge=judge)
                for judge in ("engine", "robosuite")
            )
            others = [
                chosen(runs, transfer, name, learned=True, reward=reward) for name in LEARNERS
            ]
            imitated = chosen(runs, transfer, "bc_rnn")
            found.append((before.runs[0], [before, after, stock, imitated, *others]))
    shown = [place for place in range(len(columns) + 3)
             if place < 3 or any(cells[place].runs for _, cells in found)]  # fmt: skip
    rows: list[list[object]] = []
    for first, cells in found:
        paper = PAPER[first.task, first.target]
        theirs = ["", paper["lfr"], "", *(paper.get(name, "") for name in columns)]
        seeds = len(cells[1].runs)
        rows.append([task_and_target(first), seeds, *(rate(cells[place]) for place in shown)])
        rows.append(["the paper's", "", *(theirs[place] for place in shown)])
    return markdown(header[:2] + [header[2 + place] for place in shown], rows)


def differences_table(runs: Sequence[Run]) -> str:
    """How far LfR after learning is above each method that has been run, in points."""
    names = ("bc_rnn", *LEARNERS)
    found: list[tuple[Run, list[str]]] = []
    for transfer in PAPERS:
        after = chosen(runs, transfer, "lfr", learned=True)
        if after.runs:
            unlearned = ("lfr", "retarget", "oracle", "bc_rnn")
            compared = [chosen(runs, transfer, name) for name in unlearned]
            compared += [chosen(runs, transfer, name, learned=True) for name in LEARNERS]
            found.append((after.runs[0], [above(after, one) for one in compared]))
    header = [
        "its own beginning",
        "retarget, not learned",
        "oracle",
        *map(NAMES.__getitem__, names),
    ]
    shown = [i for i in range(len(header)) if i < 3 or any(cells[i] != "-" for _, cells in found)]
    rows = [[task_and_target(first), *(cells[i] for i in shown)] for first, cells in found]
    return markdown(["task", *(header[i] for i in shown)], rows)


def chain_table(runs: Sequence[Run], transfers: Sequence[str], demonstrations: int = 50) -> str:
    """The chain of some transfers, and what comes after learning."""
    header = ["task", "from", "seeds", *(NAMES[link] for link in CHAIN), "LfR, after"]
    rows = []
    for transfer in transfers:
        links = [chosen(runs, transfer, link, demonstrations=demonstrations) for link in CHAIN]
        after = chosen(runs, transfer, "lfr", learned=True, demonstrations=demonstrations)
        if not links[CHAIN.index("lfr")].runs:
            continue
        first = links[CHAIN.index("lfr")].runs[0]
        source = NAMES[first.source]
        if first.source_controller != first.target_controller:
            source += f" ({NAMES[first.source_controller]})"
        rows.append([task_and_target(first), source, len(links[CHAIN.index("lfr")].runs),
                     *(_mean(link) for link in links), rate(after)])  # fmt: skip
    return markdown(header, rows)


def options_table(runs: Sequence[Run], transfers: Sequence[str]) -> str:
    """G by what it sees and is held to, before learning: the gain of each alone."""
    options = ("paper", "state", "hand", OURS, "no_cycle")
    header = ["task", "from", "seeds", "G(k), Eq. 4", "G(k, s), Eq. 4", "G(k), L_hand",
              "G(k, s), L_hand", "without the cycle", "L_hand, with G(k)",
              "L_hand, with G(k, s)"]  # fmt: skip
    rows = []
    for transfer in transfers:
        of = {name: chosen(runs, transfer, "lfr", option=name) for name in options}
        seeds = set.intersection(*(set(one.seeds) for one in of.values()))
        if not seeds:
            continue
        of = {name: one.of_seeds(seeds) for name, one in of.items()}
        first = of[OURS].runs[0]
        rows.append([task_and_target(first), NAMES[first.source], len(seeds),
                     *(rate(of[name]) for name in options),
                     above(of["hand"], of["paper"]), above(of[OURS], of["state"])])  # fmt: skip
    return markdown(header, rows)


def ablation_table(runs: Sequence[Run]) -> str:
    """Table III: without G, and with one common task alone; before learning and after."""
    header = ["task", "G", "no generator", "Lift alone", "Nut Assembly alone", "both"]
    lines = (("this project's, before learning", "", False), ("this project's, after", "", True),
             ("G(k), Eq. 4, before learning", "_paper", False))  # fmt: skip
    rows = []
    for transfer in PAPERS[2:]:
        for name, suffix, learned in lines:
            both = chosen(runs, transfer, "lfr", option=suffix[1:] or OURS, learned=learned)
            alone = [
                chosen(runs, transfer, "lfr", option=f"only_{task}{suffix}", learned=learned)
                for task in ("lift", "nut_assembly")
            ]
            if not alone[0].runs:
                continue
            nothing = chosen(runs, transfer, "no_generator", learned=learned)
            found = (nothing, *alone, both.of_seeds(alone[0].seeds))
            rows.append([task_and_target(alone[0].runs[0]), name, *map(rate, found)])
        known = chosen(runs, transfer, "lfr").runs
        if known:
            paper = PAPER[known[0].task, known[0].target]
            columns = ("no_generator", "only_lift", "only_nut_assembly", "lfr")
            rows.append([task_and_target(known[0]), "the paper's result",
                         *(paper[name] for name in columns)])  # fmt: skip
    return markdown(header, rows)


def matrix_table(runs: Sequence[Run], method: str = "lfr") -> str:
    """Who teaches whom: success before learning, mean of the seeds, a row for each source."""
    arms = matrix_arms(runs)
    rows = [
        [NAMES[source],
         *(_mean(matrix_cell(runs, source, target, method)) if source != target else ""
           for target in arms)]
        for source in arms
    ]  # fmt: skip
    return markdown(["from \\ to", *(NAMES[arm] for arm in arms)], rows)


def matrix_arms(runs: Iterable[Run]) -> list[str]:
    """Those that teach and learn in the matrix, by name."""
    return list(dict.fromkeys(run.source for run in runs if run.transfer.startswith("matrix-")))


def matrix_cell(runs: Iterable[Run], source: str, target: str, method: str) -> Chosen:
    """What a source has taught a target there, before learning."""
    ends = source, target, method
    return Chosen(tuple(run for run in runs if run.transfer.startswith("matrix-")
                        and (run.source, run.target, run.method) == ends))  # fmt: skip


def _mean(found: Chosen) -> str:
    return percent(found.interval.mean) if found.runs else "-"


OTHER_BODIES = (
    "ur5e-lift-ur5e-joint_position-lift", "ur5e-stack-ur5e-joint_position-stack",
    "from-ur5e-lift-panda-joint_position-lift", "from-ur5e-stack-panda-joint_position-stack",
)  # fmt: skip
LANGUAGES = (
    "from-cartesian-sawyer-panda-joint_position-stack",
    "from-cartesian-panda-sawyer-joint_position-pick_place",
)
MAPPED = (*PAPERS[2:], "ur5e-stack-ur5e-joint_position-stack")

TABLES: Mapping[str, Callable[[Sequence[Run]], str]] = {
    "methods": methods_table,
    "differences": differences_table,
    "chain": lambda runs: chain_table(runs, PAPERS),
    "bodies": lambda runs: chain_table(runs, OTHER_BODIES),
    "languages": lambda runs: chain_table(runs, LANGUAGES),
    "demonstrations": lambda runs: chain_table(runs, PAPERS, 200),
    "mappings": lambda runs: options_table(runs, MAPPED),
    "ablations": ablation_table,
    "dense": lambda runs: methods_table(runs, "dense"),
    "matrix": matrix_table,
    "matrix retarget": lambda runs: matrix_table(runs, "retarget"),
}
"""By the name of its place in docs/evidence.md."""
