"""The finished evidence: its tables against the runs that they sum up, and the README against both.

No program writes these any more, so nothing else would notice a number that was changed.
"""

import re
from functools import cache
from pathlib import Path
from statistics import fmean
from typing import Any

import pytest
from scipy.stats import trim_mean

from lfr.artifacts import read_json

ROOT = Path(__file__).parent.parent
PAPER = ROOT / "results" / "paper"
TRANSFERS = {
    "Lift, Panda": "s1-panda-lift",
    "Stack, Sawyer": "s1-sawyer-stack",
    "Stack, Panda": "s2-panda-stack",
    "Pick-Place, Sawyer": "s2-sawyer-pick_place",
}
SET_BACK = ("Stack, Panda", "Pick-Place, Sawyer")  # the transfers without our choices
LEARNED = {"LfR": "lfr", "AP": "ap"}
UNLEARNED = {
    "the source on its own arm, no learning": "own_arm",
    "the target with its own prior, no learning": "oracle",
}
Row = dict[str, str]


def section(document: Path, heading: str) -> str:
    """What stands under a heading, up to the next one."""
    text = document.read_text(encoding="utf-8")
    return text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]


def tables(text: str) -> list[list[Row]]:
    """The Markdown tables of a text, each row by the names of its columns."""
    found = []
    for block in re.findall(r"(?:^\|.*\|\n)+", text, re.MULTILINE):
        lines = [[cell.strip() for cell in line[1:-1].split("|")] for line in block.splitlines()]
        header, _, *rows = lines
        names = [name or str(place) for place, name in enumerate(header)]
        found.append([dict(zip(names, row, strict=True)) for row in rows])
    return found


@cache
def readme() -> str:
    return section(ROOT / "docs" / "cartesian-evidence.md", "Arms whose actions are the same")


@cache
def summed_up() -> dict[str, Any]:
    return read_json(PAPER / "tables.json")


def runs(folder: str, transfer: str, method: str, reward: str) -> dict[str, dict[str, Any]]:
    """Seed -> run; BC+RNN learns under no reward, so its runs stand for each."""
    name = transfer if method == "bc_rnn" else f"{transfer}-{method}"
    found = read_json(PAPER / folder / f"{name}.json")["runs"]
    return {str(run["seed"]): run for run in found if run.get("reward", reward) == reward}


def percent(rate: float) -> str:
    return f"{100 * rate:.1f}"


def interval(found: dict[str, float]) -> str:
    return f"{percent(found['value'])} [{percent(found['low'])}, {percent(found['high'])}]"


SUMS = [
    (transfer, method, reward)
    for transfer, methods in summed_up().items()
    for method, rewards in methods.items()
    for reward in rewards
]


@pytest.mark.parametrize(("transfer", "method", "reward"), SUMS)
def test_tables_sum_up_the_runs(transfer: str, method: str, reward: str) -> None:
    found = summed_up()[transfer][method][reward]
    folder = "imitate" if method == "bc_rnn" else "learn"
    by_seed = runs(folder, transfer, method, reward)
    rates = {seed: run["success"]["engine"]["rate"] for seed, run in by_seed.items()}
    assert found["rates"] == rates
    assert found["seeds"] == len(rates)
    assert found["mean"]["value"] == pytest.approx(fmean(rates.values()))
    assert found["iqm"]["value"] == pytest.approx(trim_mean(list(rates.values()), 0.25))
    stock = [run["success"]["robosuite"]["rate"] for run in by_seed.values()]
    assert found["stock"] == pytest.approx(fmean(stock))
    if found["zero_shot"] is not None:  # imitation has no such beginning; a reward changes nothing
        first = runs(folder, transfer, method, "sparse")
        before = [first[seed]["zero_shot"]["rate"] for seed in by_seed]
        assert found["zero_shot"] == pytest.approx(fmean(before))
    for one in (found["mean"], found["iqm"]):
        assert one["low"] <= one["value"] <= one["high"]


def test_the_readme_shows_what_the_tables_hold() -> None:
    rows = tables(readme())[0]
    assert {(row["task"], row["reward"]) for row in rows} == {
        (task, reward) for task in TRANSFERS for reward in ("sparse", "dense")
    }
    for row in rows:
        found = summed_up()[TRANSFERS[row["task"]]]["lfr"][row["reward"]]
        shown = {name: row[name] for name in ("LfR, mean", "LfR, IQM", "seeds", "zero-shot",
                                              "robosuite")}  # fmt: skip
        assert shown == {
            "LfR, mean": percent(found["mean"]["value"]),
            "LfR, IQM": interval(found["iqm"]),
            "seeds": str(found["seeds"]),
            "zero-shot": percent(found["zero_shot"]),
            "robosuite": percent(found["stock"]),
        }


def test_the_readme_shows_goals_and_rivals_as_the_report_does() -> None:
    (reached,) = tables(section(PAPER / "report.md", "What was to be reached"))
    pairs = {"paper's LfR": "paper", "goal": "goal", "LfR, mean": "mean", "LfR, IQM": "IQM",
             "seeds": "n", "not below": "not below LfR"}  # fmt: skip
    for mine, theirs in zip(tables(readme())[0], reached, strict=True):
        assert (mine["task"], mine["reward"]) == (theirs["task"], theirs["reward"])
        assert {name: mine[name] for name in pairs} == {
            name: theirs[other] for name, other in pairs.items()
        }


def test_the_readme_shows_what_is_left_without_our_choices() -> None:
    """The means from the runs; the intervals, which were drawn, as the report has them."""
    rows = tables(readme())[1]
    assert rows in tables(section(PAPER / "report.md", "In short"))
    for row in rows:
        what, _, reward = row["0"].rpartition(", ")
        for task in SET_BACK:
            transfer = TRANSFERS[task]
            if row["0"] in UNLEARNED:
                found = read_json(PAPER / "plain" / f"{transfer}.json")["links"]
                each = found[UNLEARNED[row["0"]]]["runs"]
                rates = [run["rate"] for run in each]
            elif row["0"] == "BC+RNN":
                each = runs("imitate_plain", transfer, "bc_rnn", "").values()
                rates = [run["success"]["engine"]["rate"] for run in each]
            else:
                each = runs("learn_plain", transfer, LEARNED[what], reward).values()
                rates = [run["success"]["engine"]["rate"] for run in each]
            assert row[task].split(" ")[0] == percent(fmean(rates)), row["0"]


def test_the_readmes_sentences_are_those_of_the_report() -> None:
    said = [line for line in readme().splitlines() if line.startswith(("**On ", "LfR's success"))]
    assert len(said) == 2
    report = section(PAPER / "report.md", "In short").splitlines()
    assert [line for line in said if line not in report] == []


def test_identity_is_level_with_lfr_on_as_many_tasks_as_is_said() -> None:
    """By the intervals of the interquartile means, which overlap."""
    first = tables(section(PAPER / "report.md", "In short"))[0]
    by_name = {row["0"]: row for row in first}
    bounds = {
        (name, task): tuple(map(float, re.findall(r"[\d.]+", by_name[name][task])[1:]))
        for name in ("LfR, sparse", "LfR, dense", "identity (no learning)")
        for task in TRANSFERS
    }
    level = 0
    for task in TRANSFERS:
        low, high = bounds["identity (no learning)", task]
        ours = [bounds[f"LfR, {reward}", task] for reward in ("sparse", "dense")]
        level += all(low <= top and bottom <= high for bottom, top in ours)
    assert f"**On {level} of {len(TRANSFERS)} tasks" in readme()
