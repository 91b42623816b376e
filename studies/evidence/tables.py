"""The tables of docs/evidence.md, from the table of all runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from lfr.evaluation.results_tables import markdown, percent
from studies.evidence.evidence_params import OURS
from studies.evidence.runs import Run
from studies.evidence.statistics import Interval, Outcomes, difference, outcomes_of, success

PAPER: Mapping[tuple[str, str], Mapping[str, float]] = {
    ("lift", "panda"): {"bc_rnn": 42.0, "ap": 56.6, "sac": 89.0, "lfr": 98.0},
    ("stack", "sawyer"): {"bc_rnn": 36.0, "ap": 58.0, "sac": 40.5, "lfr": 92.0},
    ("stack", "panda"): {
        "bc_rnn": 42.8, "ap": 37.0, "sac": 30.2, "lfr": 90.2,
        "no_generator": 5.0, "only_lift": 67.8, "only_nut_assembly": 87.6,
    },
    ("pick_place", "sawyer"): {
        "bc_rnn": 16.3, "ap": 10.6, "sac": 0.0, "lfr": 82.5,
        "no_generator": 3.5, "only_lift": 42.4, "only_nut_assembly": 76.0,
    },
}  # fmt: skip
"""What the paper's Tables I to III say, percent, by new task and target."""

PAPERS = ("s1-panda-joint_position-lift", "s1-sawyer-joint_position-stack",
          "s2-panda-joint_position-stack", "s2-sawyer-joint_position-pick_place")  # fmt: skip
"""The paper's transfers, in joint space."""

CHAIN = ("own_arm", "identity", "no_generator", "linear", "lfr", "recoded", "retarget", "oracle")
NAMES = {
    "own_arm": "own arm", "identity": "identity", "no_generator": "no generator",
    "linear": "linear", "lfr": "LfR", "recoded": "recoded", "retarget": "retarget",
    "oracle": "oracle", "bc_rnn": "BC+RNN", "ap": "AP", "sac": "SAC", "spirl": "SPiRL",
    "lift": "Lift", "stack": "Stack", "pick_place": "Pick-Place", "nut_assembly": "Nut Assembly",
    "panda": "Panda", "sawyer": "Sawyer", "ur5e": "UR5e", "iiwa": "iiwa", "kinova3": "Kinova3",
    "xarm7": "xArm7", "jaco": "Jaco", "osc_pose": "Cartesian", "joint_position": "joints",
}  # fmt: skip


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
    mean, low, high = (100 * value for value in difference(*both))
    return f"{mean:+.0f} ({low:+.0f} to {high:+.0f})"


def task_and_target(run: Run) -> str:
    """``Stack, Panda``."""
    return f"{NAMES[run.task]}, {NAMES[run.target]}"


def methods_table(runs: Sequence[Run], reward: str = "sparse") -> str:
    """Tables I and II: every method on the paper's transfers, and the paper's own figures below."""
    learners = ("ap", "sac", "spirl", "no_generator", "retarget")
    header = ["task", "seeds", "LfR, before", "LfR, after", "robosuite", "BC+RNN",
              *(NAMES[name] for name in learners)]  # fmt: skip
    rows = []
    for transfer in PAPERS:
        before = chosen(runs, transfer, "lfr")
        if not before.runs:
            continue
        after = chosen(runs, transfer, "lfr", learned=True, reward=reward)
        stock = chosen(runs, transfer, "lfr", learned=True, reward=reward, judge="robosuite")
        others = [chosen(runs, transfer, name, learned=True, reward=reward) for name in learners]
        rows.append([
            task_and_target(before.runs[0]), len(after.runs), rate(before), rate(after),
            rate(stock), rate(chosen(runs, transfer, "bc_rnn")), *map(rate, others),
        ])  # fmt: skip
        paper = PAPER[before.runs[0].task, before.runs[0].target]
        rows.append(["the paper's", "", "", paper["lfr"], "", paper["bc_rnn"],
                     *(paper.get(name, "") for name in learners)])  # fmt: skip
    return markdown(header, rows)


def differences_table(runs: Sequence[Run]) -> str:
    """How far LfR after learning is above each method, in points."""
    learners = ("ap", "sac", "spirl", "no_generator", "retarget")
    header = ["task", "BC+RNN", *(NAMES[name] for name in learners), "its own beginning"]
    rows = []
    for transfer in PAPERS:
        after = chosen(runs, transfer, "lfr", learned=True)
        if not after.runs:
            continue
        others = [chosen(runs, transfer, name, learned=True) for name in learners]
        beginning = chosen(runs, transfer, "lfr")
        compared = [chosen(runs, transfer, "bc_rnn"), *others, beginning]
        rows.append([task_and_target(after.runs[0]), *(above(after, one) for one in compared)])
    return markdown(header, rows)


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
