"""Tables, against counts by hand."""

from __future__ import annotations

import pytest

from studies.evidence.statistics import success
from studies.evidence.tables import TABLES, above, chosen, matrix_table, rate
from tests.studies.evidence.made_up import run

S2 = "s2-panda-joint_position-stack"


def cells(table: str) -> list[list[str]]:
    header, _, *rows = table.strip().splitlines()
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in (header, *rows)]


def test_one_policy_is_chosen_among_all() -> None:
    runs = [
        run("1100", seed=1), run("1111", seed=0), run("0000", option="paper"),
        run("0000", env_steps=40_001), run("0000", env_steps=40_001, judge="robosuite"),
        run("0000", demonstrations=200), run("0000", method="identity"),
        run("0000", transfer="s1-sawyer-joint_position-stack"),
    ]  # fmt: skip
    found = chosen(runs, S2, "lfr")
    assert found.seeds == (0, 1)
    assert found.interval == success(found.outcomes)
    assert found.interval.mean == 0.75
    assert rate(found).startswith("75 (")
    assert len(chosen(runs, S2, "lfr", learned=True).runs) == 1
    assert len(chosen(runs, S2, "lfr", learned=True, judge="robosuite").runs) == 1
    assert rate(chosen(runs, S2, "oracle")) == "-"


def test_a_difference_is_over_the_seeds_of_both() -> None:
    first = chosen([run("1111", seed=seed) for seed in range(5)], S2, "lfr")
    second = chosen(
        [run("1100", seed=seed, method="retarget") for seed in range(3)], S2, "retarget"
    )
    assert above(first, second).startswith("+50 (")
    assert above(second, first).startswith("-50 (")
    assert above(first, chosen([], S2, "retarget")) == "-"


def test_the_chain_has_each_links_mean() -> None:
    links = {"own_arm": "1111", "identity": "0000", "no_generator": "0000", "linear": "1000",
             "lfr": "1110", "recoded": "1100", "retarget": "1111", "oracle": "1111"}  # fmt: skip
    runs = [run(outcomes, method=method) for method, outcomes in links.items()]
    runs.append(run("1111", env_steps=40_001))
    header, *rows = cells(TABLES["chain"](runs))
    (row,) = rows
    assert row[:-1] == [
        "Stack, Panda",
        "Sawyer",
        "1",
        "100",
        "0",
        "0",
        "25",
        "75",
        "50",
        "100",
        "100",
    ]
    assert row[-1].startswith("100 (")
    assert header[-1] == "LfR, after"


def test_options_are_compared_over_common_seeds() -> None:
    options = {"paper": "0000", "state": "1000", "hand": "1100", "ours": "1110", "no_cycle": "1111"}
    runs = [run(outcomes, option=name) for name, outcomes in options.items()]
    runs.append(run("1111", seed=1))  # of ours alone
    _, row = cells(TABLES["mappings"](runs))
    assert row[2] == "1"
    assert [cell.split()[0] for cell in row[3:]] == ["0", "25", "50", "75", "100", "+50", "+50"]


def test_the_matrix_is_from_rows_to_columns() -> None:
    taught = {("panda", "sawyer"): "1111", ("sawyer", "panda"): "1000"}
    runs = [
        run(outcomes, source=source, target=target, transfer=f"matrix-{source}-{target}-stack")
        for (source, target), outcomes in taught.items()
    ]
    assert cells(matrix_table(runs)) == [
        ["from \\ to", "Panda", "Sawyer"], ["Panda", "", "100"], ["Sawyer", "25", ""],
    ]  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_without_runs_a_table_has_no_rows(name: str) -> None:
    assert len(cells(TABLES[name]([]))) == 1
