"""Records, tables and the figure, from results written by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from lfr.artifacts import read_json, write_json
from lfr.errors import DataError
from lfr.evaluation import figures
from lfr.evaluation import results_tables as tables
from lfr.evaluation.records import CHAIN, chain_records, read_runs, transfer_records
from lfr.evaluation.results_page import report
from lfr.evaluation.success_rate import success_of

NAME = "s1-panda-lift-lfr"


def rate(successes: int, episodes: int = 100) -> dict[str, Any]:
    return {**vars(success_of(successes, episodes)), "steps": 40.0}


@pytest.fixture
def results(tmp_path: Path) -> Path:
    learned = {
        "transfer": "s1-panda-lift",
        "method": "lfr",
        "reward": "sparse",
        "warm_up": 1000,
        "runs": [{"seed": seed, "env_steps": 50_004} for seed in (0, 1)],
        "datasets": {"panda-nut_assembly": "ab" * 32},
        "provenance": {
            "revision": "c0ffee",
            "modified": True,
            "python": "3.12.1",
            "platform": "Linux",
            "packages": {"mujoco": "3.9.0"},
        },
        "peak_memory": 3 * 2**29,
        "seconds": 1.0,
    }
    judged = {
        "judge": "engine",
        "runs": [
            {"seed": 0, "zero_shot": rate(50), "success": {"engine": rate(97), "other": rate(96)}},
            {"seed": 1, "zero_shot": rate(52), "success": {"engine": rate(99), "other": rate(98)}},
        ],
        "seconds": 1.0,
    }
    rates = {link: rate(10 * i) for i, link in enumerate(CHAIN)}
    zero_shot = {link: rates[link] for link in CHAIN[1:-1]}
    rmse = {"lift": {"rmse": {"dx": 0.1, "dy": 0.1, "dz": 0.1}}}
    for robot, link in (("sawyer", "own_arm"), ("panda", "oracle")):
        prior = {"lift": {"own_arm": rates[link], "kl_held_out": 5.0}}
        model = {"tasks": ["lift", "pick_place"], "prior": prior, "held_out": rmse}
        skills = {"robot": robot, "models": {"lift+pick_place": model}, "seconds": 1.5}
        write_json(tmp_path / "skills" / f"{robot}.json", skills)
    names = {"source": "sawyer/lift+pick_place", "target": "panda/pick_place",
             "oracle": "panda/lift+pick_place"}  # fmt: skip
    chain = {"source": "sawyer", "target": "panda", "task": "lift", "skills": names,
             "zero_shot": zero_shot, "seconds": 2.0}  # fmt: skip
    record = {"seconds": 10.0, "peak_memory": 2**30, "provenance": {"revision": "b0a7"}}
    lengths = {"episodes": 50, "attempts": 50, "expert_success": 1.0, "frames": 2500,
               "length": {"median": 50.0}}  # fmt: skip
    write_json(tmp_path / "record" / "panda-lift.json", {**record, **lengths})
    write_json(tmp_path / "transfer" / f"{NAME}.json", learned)
    write_json(tmp_path / "evaluate" / f"{NAME}.json", judged)
    write_json(tmp_path / "chain" / "s1-panda-lift.json", chain)
    (tmp_path / "transfer" / f"{NAME}.csv").write_text(
        "seed,env_steps,success,kl\n0,0,0.5,\n0,50004,0.95,1.5\n1,0,0.55,\n1,50004,1.0,1.4\n"
    )
    return tmp_path


def test_one_record_for_each_run(results: Path) -> None:
    records = transfer_records(read_runs(["s1-panda-lift"], ["lfr"], results))
    assert [record["seed"] for record in records] == [0, 1]
    first = records[0]
    low, high = success_of(97, 100).low, success_of(97, 100).high
    assert first["success_interval"] == [low, high]
    expected = {
        "transfer": "s1-panda-lift", "method": "lfr", "reward": "sparse", "env_steps": 50_004,
        "zero_shot": 0.5, "success": 0.97, "episodes": 100, "judge": "engine",
    }  # fmt: skip
    assert {key: first[key] for key in expected} == expected
    assert first["revisions"]["git"] == "c0ffee"
    assert first["revisions"]["datasets"] == {"panda-nut_assembly": "ab" * 32}


def test_tables_show_the_rates(results: Path) -> None:
    records = transfer_records(read_runs(["s1-panda-lift"], ["lfr"], results))
    chains = chain_records(["s1-panda-lift"], results)
    table = tables.transfer_table(records, chains)
    header, _, *rows = (
        [cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()
    )
    for row in rows:
        beside = dict(zip(header, row, strict=True))
        for link in ("identity", "no generator", "linear", "retarget", "oracle"):
            rate = chains["s1-panda-lift"]["zero_shot"][link.replace(" ", "_")]["rate"]
            assert beside[link] == f"{100 * rate:.0f}"
    assert "| -" in tables.transfer_table(records, {}).splitlines()[2]
    assert "50 (40-60)" in table
    assert "97 (92-99)" in table
    assert len(table.splitlines()) == 2 + 2
    assert len({len(line) for line in table.splitlines()}) == 1
    assert "| 10 (" in tables.chain_table(chains)
    rates = {link: one["rate"] for link, one in chains["s1-panda-lift"]["zero_shot"].items()}
    assert rates == {link: i / 10 for i, link in enumerate(CHAIN)}
    shown = tables.summary(records, chains)[NAME]
    assert shown["success"] == pytest.approx(0.98)
    assert shown["zero_shot"] == pytest.approx(0.51)
    assert shown["oracle"] == pytest.approx(0.7)


def test_links_that_the_arms_do_not_allow_are_left_out(results: Path) -> None:
    file = results / "chain" / "s1-panda-lift.json"
    chain = read_json(file)
    del chain["zero_shot"]["recoded"]
    write_json(file, chain)
    chains = chain_records(["s1-panda-lift"], results)
    assert tuple(chains["s1-panda-lift"]["zero_shot"]) == (
        "own_arm", "identity", "no_generator", "linear", "mapped", "retarget", "oracle",
    )  # fmt: skip
    header, _, row = tables.chain_table(chains).splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in (header, row)]
    found = dict(zip(*cells, strict=True))
    assert found["recoded"] == "-"
    assert found["mapped"].startswith("50 (")
    records = transfer_records(read_runs(["s1-panda-lift"], ["lfr"], results))
    assert "recoded" not in tables.summary(records, chains)[NAME]


def test_the_report_says_of_each_stage_how_it_ran(results: Path) -> None:
    records = transfer_records(read_runs(["s1-panda-lift"], ["lfr"], results))
    text = report(records, chain_records(["s1-panda-lift"], results), results)
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines()]
    stages = {row[0]: row[1:] for row in rows if len(row) == 5}
    assert stages["record"] == ["1", "10", "1.00", "b0a7"]
    assert stages["transfer"] == ["1", "1", "1.50", "c0ffee+"]
    assert stages["evaluate"] == ["1", "1", "-", "?"]  # left by a stage that did not say
    assert stages["all"] == ["5", "15", "1.50", ""]
    skilled = [row for row in rows if row[1:3] == ["lift, pick_place", "lift"]]
    assert [row[0] for row in skilled] == ["panda", "sawyer"]
    assert "- transfer: Python 3.12.1, Linux; mujoco 3.9.0." in text


def test_a_run_that_was_not_evaluated_is_named(results: Path) -> None:
    (results / "evaluate" / f"{NAME}.json").unlink()
    with pytest.raises(DataError, match=r"missing.*evaluate/s1-panda-lift-lfr\.json"):
        read_runs(["s1-panda-lift"], ["lfr"], results)


def test_an_evaluation_of_other_seeds_is_refused(results: Path) -> None:
    write_json(results / "evaluate" / f"{NAME}.json", {"judge": "engine", "runs": [{"seed": 3}]})
    with pytest.raises(DataError, match=r"other seeds.*found \[3\], expected \[0, 1\]"):
        read_runs(["s1-panda-lift"], ["lfr"], results)


def test_the_figure_is_the_same_bytes_again(results: Path) -> None:
    curves = {
        ("s1-panda-lift", "lfr"): figures.read_curves(results / "transfer" / f"{NAME}.csv"),
    }
    assert curves["s1-panda-lift", "lfr"][1][-1] == {"env_steps": 50_004.0, "success": 1.0}
    records = transfer_records(read_runs(["s1-panda-lift"], ["lfr"], results))
    files = [results / "a.svg", results / "b.svg"]
    for file in files:
        figures.learning_figure(file, curves, records, warm_up=1000)
    assert files[0].read_bytes() == files[1].read_bytes()
    assert b"<svg" in files[0].read_bytes()
