"""Records, tables, targets, figures and text, from made-up results in every state of completion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.stats import binomtest

from lfr.artifacts import read_json, write_json
from lfr.errors import DataError
from lfr.evaluation.evidence.claims import disagreements, standings
from lfr.evaluation.evidence.findings import findings, short_table
from lfr.evaluation.evidence.names import REWARDS, method_label
from lfr.evaluation.evidence.published import PUBLISHED, TABLES, TASKS
from lfr.evaluation.evidence.readme import (
    BEGIN,
    END,
    NOT_YET,
    evidence_block,
    shown_evidence,
    update_evidence,
)
from lfr.evaluation.evidence.records import read_evidence
from lfr.evaluation.evidence.report import report
from lfr.evaluation.evidence.summary import summarise
from lfr.evaluation.evidence.tables import (
    methods_table,
    overall_table,
    paper_table,
    questions_table,
)
from lfr.evaluation.evidence.targets import (
    TARGETS,
    expected_rivals,
    standing,
    steps_to_goal,
    targets_table,
)
from lfr.params import read_yaml
from lfr.scenarios import transfers
from pipeline.paper import report as stage
from tests.evaluation.evidence.made_up import imitated, learned, zero_shot

LIFT, CAN = "s1-panda-lift", "s2-sawyer-pick_place"
ROOT = Path(__file__).parents[3]


@pytest.fixture
def paper(tmp_path: Path) -> Path:
    """LfR with both rewards, AP with one, BC+RNN and links, of one transfer alone."""
    folder = tmp_path / "results" / "paper"
    learned(folder, LIFT, "lfr", {"sparse": [98, 100, 99, 97, 96], "dense": [80, 84]}, before=90)
    learned(folder, LIFT, "ap", {"sparse": [40, 100, 70]})
    imitated(folder, LIFT, [30, 50])
    zero_shot(folder, LIFT, {"constant": [0, 2], "identity": [98, 100], "own_arm": [99, 97]})
    return folder


def cells(table: str, start: str) -> list[list[str]]:
    """The cells of a Markdown table's rows whose first cell is ``start``."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()]
    return [row for row in rows if row and row[0] == start]


def test_every_run_is_a_record(paper: Path) -> None:
    evidence = read_evidence(paper)
    assert len(evidence.runs) == 5 + 2 + 3 + 2
    assert evidence.rewards() == ["sparse", "dense"]
    assert evidence.methods() == ["lfr", "bc_rnn", "ap"]
    first = evidence.of(LIFT, "lfr", "sparse")[0]
    assert (first.success, first.stock, first.zero_shot, first.env_steps) == (
        0.98,
        0.97,
        0.9,
        10_000,
    )
    assert first.auc == pytest.approx(0.94)
    assert first.steps_to == (0, 0, 10_000)
    imitation = evidence.of(LIFT, "bc_rnn", "dense")[0]
    assert (imitation.reward, imitation.auc, imitation.steps_to) == (None, None, ())
    assert list(evidence.links[LIFT].links) == ["own_arm", "identity", "constant"]
    assert set(evidence.stages) == {"learn", "imitate", "zero_shot"}


def test_summary_by_hand(paper: Path) -> None:
    evidence = read_evidence(paper)
    ours = summarise(evidence, LIFT, "lfr", "sparse")
    ap = summarise(evidence, LIFT, "ap", "sparse")
    assert ours is not None
    assert ap is not None
    assert (ours.mean.value, ours.iqm.value) == pytest.approx((0.98, 0.98))
    assert (ap.mean.value, ap.iqm.value) == pytest.approx((0.7, 0.7))
    assert ap.auc == pytest.approx(0.6)  # straight lines from .5 to .4, 1 and .7
    assert ap.steps_to == (0, None, None)  # 80 % by one of three
    assert ap.improvement is not None
    # 40 and 70 lose to each of five; 100 wins against four and ties with one
    assert ap.improvement.value == pytest.approx((5 + 5 + 0.5) / 15)
    assert ours.improvement is None
    assert summarise(evidence, LIFT, "sac", "sparse") is None
    assert summarise(evidence, CAN, "lfr", "sparse") is None


def test_table_one_has_ours_over_the_papers(paper: Path) -> None:
    table = paper_table(TABLES["table1"], read_evidence(paper))
    sparse, dense = table.split("## Dense reward")
    (row,) = cells(sparse, "Lift, Panda")
    assert row[1] == "here"
    assert row[2].startswith("40.0; IQM 40.0 [")
    assert row[2].endswith("; n = 2")
    assert row[3].startswith("70.0; IQM 70.0 [")
    assert row[4] == "- (n = 0)"
    assert row[5].startswith("98.0; IQM 98.0 [")
    assert row[5].endswith("; n = 5")
    papers = [one for one in cells(sparse, "") if one[1] == "paper"]
    assert papers[0][2:] == ["42.0 ± 2.2", "56.6 ± 1.4", "89.0 ± 0.2", "98.0 ± 0.6"]
    (row,) = cells(dense, "Lift, Panda")
    assert (row[3], row[5].split(";")[0]) == ("- (n = 0)", "82.0")
    assert row[2].startswith("40.0; IQM 40.0 [")


def test_the_papers_figures_are_of_transfers_and_tables_there_are() -> None:
    known = transfers(ROOT / "params.yaml")
    assert set(TASKS) == set(TARGETS) <= set(known)
    needed = {(name, method) for table in TABLES.values()
              for name in table.transfers for method in table.methods}  # fmt: skip
    assert needed == set(PUBLISHED)
    assert len(PUBLISHED) == 22  # success rates in the paper's three tables
    for table in TABLES.values():
        for name in table.transfers:
            only = {m.removeprefix("only_") for m in table.methods if m.startswith("only_")}
            assert only <= set(known[name].common)


def test_links_have_an_interval_over_seeds_and_each_seed_is_shown(paper: Path) -> None:
    zero_shot(paper, CAN, {"identity": [0, 100], "constant": [0, 0]})
    table = questions_table(read_evidence(paper))
    (row,), (constant,) = cells(table, "`identity`"), cells(table, "`constant`")
    assert row[2].startswith("99.0 [9")
    assert row[2].endswith("] (98, 100)")
    # All 200 episodes together would have it that the half is sure to 7 points.
    assert row[5] == "50.0 [0.0, 100.0] (0, 100)"
    assert constant[5] == "0.0 [0.0, 3.7] (0, 0)"  # Wilson's of 0 of 200
    assert row[3:5] == ["-"] * 2
    names = [line.split("|")[1].strip() for line in table.splitlines()[2:]]
    assert names == ["`own_arm`", "`identity`", "`constant`"]


def test_a_method_row_says_never_and_dash(paper: Path) -> None:
    evidence = read_evidence(paper)
    rows = methods_table([found for name in ("sac", "ap", "bc_rnn")
                          if (found := summarise(evidence, LIFT, name, "sparse"))])  # fmt: skip
    (ap,), (imitation,) = cells(rows, "AP"), cells(rows, "BC+RNN")
    assert ap[5:10] == ["40, 100, 70", "50.0", "69.0", "0.600", "10000"]
    assert ap[10:13] == ["0", "never", "never"]
    assert imitation[6:13] == ["-"] * 7


def test_who_stands_in_the_way(paper: Path) -> None:
    evidence = read_evidence(paper)
    place = standing(evidence, LIFT, "sparse")
    assert place is not None
    assert set(place.below) == {"BC+RNN"}
    assert set(place.level) == {"AP", "identity (no learning)"}
    dense = standing(evidence, LIFT, "dense")
    assert dense is not None
    assert set(dense.above) == {"identity (no learning)"}
    row = cells(targets_table(evidence), "Lift, Panda")[0]
    assert row[2:5] == ["98.0", "99", "98.0"]
    assert (row[7], row[10], row[11]) == ("no", "no", "no")
    assert row[12] == "AP, identity (no learning)"
    text = standings(evidence)
    assert "Worse: BC+RNN 40.0 [" in text
    assert "Not measured yet: SAC" in text


def test_who_has_more_seeds_gains_nothing_by_it(tmp_path: Path) -> None:
    """Of LfR's five seeds the interquartile mean would leave out the one that fails."""
    learned(tmp_path, CAN, "lfr", {"sparse": [20, 99, 99, 99, 99]})
    learned(tmp_path, CAN, "spirl", {"sparse": [60, 60, 60]})
    zero_shot(tmp_path, CAN, {"recoded": [60, 60, 60], "identity": [60] * 5})
    evidence = read_evidence(tmp_path)
    place = standing(evidence, CAN, "sparse")
    assert place is not None
    assert place.ours.value == pytest.approx(0.99)
    assert "SPiRL (common prior)" in place.level
    assert "recoded (no learning)" in place.level
    (row,) = cells(overall_table(evidence), "SPiRL (common prior)")
    assert row[4].startswith("72.7 [")  # of 20, 99 and 99


def test_where_a_run_starts_does_not_depend_on_its_reward(paper: Path) -> None:
    file = paper / "learn" / f"{LIFT}-lfr.json"
    content = read_json(file)
    for run in content["runs"]:
        if run["reward"] == "dense":
            run["zero_shot"] = None  # as the stage writes it: judged once
    write_json(file, content)
    found = read_evidence(paper).of(LIFT, "lfr", "dense")
    assert [run.zero_shot for run in found] == [0.9, 0.9]


def test_ablations_and_oracles_do_not_stand_in_the_way(tmp_path: Path) -> None:
    learned(tmp_path, CAN, "lfr", {"sparse": [95, 96]})
    learned(tmp_path, CAN, "only_lift", {"sparse": [100, 100]})
    learned(tmp_path, CAN, "sac", {"sparse": [0, 3]})
    zero_shot(tmp_path, CAN, {"oracle": [100, 100], "shared_vae": [10, 12]})
    place = standing(read_evidence(tmp_path), CAN, "sparse")
    assert place is not None
    above = cells(targets_table(read_evidence(tmp_path)), "Pick-Place, Sawyer")[0][11]
    assert above == "so far"  # BC+RNN, AP and others are not there
    assert set(place.below) == {"SAC", "shared VAE (no learning)"}
    assert not place.in_the_way


def test_rivals_are_those_who_learn_by_the_parameters() -> None:
    learn = read_yaml(ROOT / "paper/params.yaml")["learn"]
    places = {"tables": list(TASKS), "questions": learn["ablated"]}
    for transfer in TASKS:
        for reward in REWARDS:
            learners = {method for group, transfers in places.items()
                        if transfer in transfers and reward in learn["rewards"][group]
                        for method in learn["methods"][group]}  # fmt: skip
            labels = {method_label(method) for method in learners | {"bc_rnn"}} - {"LfR"}
            rivals = expected_rivals(transfer, reward)
            assert {name for name in rivals if not name.endswith("(no learning)")} == labels


def test_a_goal_is_reached_in_time_or_not(tmp_path: Path) -> None:
    learned(tmp_path, LIFT, "lfr", {"sparse": [99, 99], "dense": [99, 99]}, 50, 40_000)
    learned(tmp_path, CAN, "lfr", {"sparse": [97, 98], "dense": [90, 100]}, 97, 60_000)
    evidence = read_evidence(tmp_path)
    assert steps_to_goal(evidence.of(LIFT, "lfr", "sparse"), 0.99) == 40_000
    assert steps_to_goal(evidence.of(LIFT, "lfr", "sparse"), 0.7) == 20_000
    assert steps_to_goal(evidence.of(CAN, "lfr", "sparse"), 0.97) == 0
    assert steps_to_goal(evidence.of(CAN, "lfr", "dense"), 0.99) is None
    table = targets_table(evidence)
    lift, can, lost = *cells(table, "Lift, Panda")[:1], *cells(table, "Pick-Place, Sawyer")
    assert (lift[7], lift[9], lift[10]) == ("yes", "40000", "no")
    assert (can[7], can[9], can[10]) == ("yes", "0", "yes")
    assert (lost[7], lost[10]) == ("no", "no")
    assert cells(table, "Stack, Panda")[0][4:8] == ["-", "-", "0", "-"]


def test_the_paper_is_disagreed_with_where_the_intervals_are_apart(paper: Path) -> None:
    assert disagreements(read_evidence(paper)).startswith("None")
    learned(paper, LIFT, "lfr", {"sparse": [80, 84], "dense": [60, 62]})
    (dense,) = cells(disagreements(read_evidence(paper)), "Lift, Panda")  # 82 is not far from 98
    wilson = binomtest(29, 30).proportion_ci(method="wilson")  # 98 % of 30 trials
    paper_cell = f"98.0 [{100 * wilson.low:.1f}, {100 * wilson.high:.1f}]"
    assert dense[1:4] == ["LfR", "dense", paper_cell]
    assert dense[5] == "-37.0"


def test_one_seed_twice_is_refused(paper: Path) -> None:
    again = (paper / "imitate" / f"{LIFT}.json").read_text()
    (paper / "imitate" / "again.json").write_text(again)
    with pytest.raises(DataError, match="twice"):
        read_evidence(paper)


def test_a_run_without_its_curve_is_refused(paper: Path) -> None:
    file = paper / "learn" / f"{LIFT}-lfr.csv"
    file.write_text("".join(line for line in file.open() if not line.startswith("dense,1")))
    with pytest.raises(DataError, match=r"no curve.*dense, seed 1"):
        read_evidence(paper)


def test_report_sums_the_stages(paper: Path) -> None:
    text = report(read_evidence(paper))
    assert "All stages together took 2.00 hours" in text
    assert "what Tables I to III need took 1.50" in text
    missing = (
        "models, variants, reference, plain_demonstrations, plain, learn_plain, imitate_plain, "
        "plain_parts"
    )
    assert f"Nothing is there yet of: {missing}." in text
    assert "LfR 90 (at most 90)" in text
    assert "## Table III: ablations" in text
    assert len(text.split("\n# ")) == 1  # one title


@pytest.mark.parametrize("whole", [False, True], ids=["nothing yet", "some"])
def test_stage_writes_everything_and_the_same_again(
    whole: bool, paper: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path if whole else tmp_path / "empty"
    folder.mkdir(exist_ok=True)
    monkeypatch.chdir(folder)
    readme = folder / "README.md"
    readme.write_text(f"# Title\n\n{BEGIN}\n{END}\n\nThe rest.\n")
    stage.main()
    written = {path.name: path.read_bytes() for path in Path("results/paper").iterdir()
               if path.is_file()}  # fmt: skip
    assert set(written) == {
        "table1.md", "table2.md", "table3.md", "questions.md", "report.md", "tables.json",
        "figure3.svg", "figure4.svg", "ablations.svg", "questions.svg", "headline.svg",
    }  # fmt: skip
    for link in ("headline.svg", "figure3.svg"):
        assert f"({link})".encode() in written["report.md"]
    assert b"(questions.svg)" not in written["report.md"]  # LfR alone would be in it
    assert shown_evidence(readme) == evidence_block()
    assert (shown_evidence(readme) == NOT_YET) is not whole
    assert readme.read_text().endswith(f"\n{END}\n\nThe rest.\n")
    if whole:
        metrics = read_json(Path("results/paper/tables.json"))[LIFT]["lfr"]["sparse"]
        assert metrics["mean"]["value"] == pytest.approx(0.98)
        assert metrics["rates"] == {"0": 0.98, "1": 1.0, "2": 0.99, "3": 0.97, "4": 0.96}
        stage.main()
        assert all(written[name] == Path("results/paper", name).read_bytes() for name in written)


@pytest.mark.parametrize("text", ["no markers", BEGIN, f"{END}\n{BEGIN}\n", f"{BEGIN}\n{BEGIN}\n"])
def test_missing_or_doubled_markers_are_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "README.md"
    path.write_text(text)
    with pytest.raises(DataError, match=r"README\.md"):
        update_evidence(path, "block")
    assert path.read_text() == text


def test_the_page_names_every_file_of_the_report() -> None:
    page = (ROOT / "docs" / "evidence.md").read_text()
    outs = yaml.safe_load((ROOT / "paper" / "dvc.yaml").read_text())["stages"]["report"]["outs"]
    files = [Path(next(iter(out)) if isinstance(out, dict) else out).name for out in outs]
    assert len(files) > 10
    assert [name for name in files if f"`{name}`" not in page] == []


def test_the_page_names_every_method_of_the_evidence() -> None:
    page = (ROOT / "docs" / "evidence.md").read_text()
    groups = yaml.safe_load((ROOT / "paper" / "params.yaml").read_text())["learn"]["methods"]
    methods = [method for group in groups.values() for method in group]
    assert [name for name in ("bc_rnn", *methods) if f"`{name}`" not in page] == []


def test_what_the_page_says_of_the_papers_trials() -> None:
    """Of three tests of ten trials: 22 rates, of which 0.0 alone can occur, and 4.7 points."""
    possible = {f"{100 * k / 30:.1f}" for k in range(31)}
    rates = [f"{cell.rate:.1f}" for cell in PUBLISHED.values()]
    assert (len(rates), sum(rate in possible for rate in rates)) == (22, 1)
    assert float(np.std([100, 100, 90])) == pytest.approx(4.7, abs=0.05)
    assert PUBLISHED["s2-panda-stack", "no_generator"].rate == 5.0
    assert PUBLISHED["s2-panda-stack", "ap"].rate == 37.0


def test_a_beginning_is_judged_once_for_both_rewards(paper: Path) -> None:
    file = paper / "learn" / f"{LIFT}-lfr.json"
    content = read_json(file)
    for run in content["runs"]:
        if run["reward"] == "dense":
            run["zero_shot"] = None
    write_json(file, content)
    evidence = read_evidence(paper)
    assert [run.zero_shot for run in evidence.of(LIFT, "lfr", "dense")] == [0.9, 0.9]
    assert steps_to_goal(evidence.of(LIFT, "lfr", "dense"), 0.9) == 0


def test_the_report_says_plainly_who_needs_no_mapping(paper: Path) -> None:
    text = findings(read_evidence(paper))
    # sparse: 98.0 of five; dense: 82 of two, far below identity's 99
    level = "is not below LfR, by overlapping or higher intervals, in"
    assert f"**Identity (no learning) {level} 2 of 2 comparisons** (1 task, LfR under" in text
    assert "Better: Lift, Panda, dense (99.0 against LfR's 82.0)" in text
    assert f"**AP {level} 1 of 1 comparison** (" in text
    assert "29.0 points below LfR's" in text
    assert "**BC+RNN does worse than LfR in 2 of 2 comparisons** (" in text
    assert "shared VAE" not in text
    assert "Lift, Panda, sparse: 90.0 to 98.0" in text
    zero_shot(paper, LIFT, {"identity": [3, 5]})
    worse = findings(read_evidence(paper))
    assert "**Identity (no learning) does worse than LfR in 2 of 2 comparisons" in worse
    assert findings(read_evidence(paper / "none")) == ""
    assert "been run yet" in short_table(read_evidence(paper / "none"))


def test_differences_are_of_the_seeds_that_both_have(tmp_path: Path) -> None:
    learned(tmp_path, CAN, "lfr", {"sparse": [20, 99, 99, 99, 99]})
    zero_shot(tmp_path, CAN, {"identity": [60, 60, 60]})
    text = findings(read_evidence(tmp_path))
    assert "Its interquartile mean is 12.7 points below LfR's." in text  # of 20, 99, 99; not 99
    assert "over all tasks compared: +12.7 [" in text
    item = standings(read_evidence(tmp_path))
    assert "identity (no learning) 60.0 [" in item
    assert "(LfR's of these seeds 72.7 [" in item
    (row,) = cells(overall_table(read_evidence(tmp_path)), "identity (no learning)")
    assert (row[2], row[4][:4], row[5][:5]) == ("1", "72.7", "+12.7")


def test_who_shares_no_seed_with_lfr_is_not_compared(tmp_path: Path) -> None:
    learned(tmp_path, CAN, "lfr", {"sparse": [90]})
    zero_shot(tmp_path, CAN, {"identity": [90, 95], "linear": [80], "mapped": [70, 75]})
    file = tmp_path / "zero_shot" / f"{CAN}.json"
    content = read_json(file)
    for link in ("identity", "mapped"):
        content["links"][link]["runs"] = content["links"][link]["runs"][1:]  # seed 1 alone
    write_json(file, content)
    text = report(read_evidence(tmp_path))
    assert "**Identity" not in text
    assert "A closed-form" not in text


def test_models_that_were_trained_twice_are_named(paper: Path) -> None:
    text = report(read_evidence(paper))
    assert "trained twice" not in text
    for method, models in (("lfr", "aa"), ("ap", "aa"), ("only_lift", "cc")):
        learned(paper, CAN, method, {"sparse": [90, 91]})
        file = paper / "learn" / f"{CAN}-{method}.json"
        content = read_json(file)
        for run in content["runs"]:
            run["models"] = models
        write_json(file, content)
    assert "trained twice" not in report(read_evidence(paper))  # a variant has its own
    file = paper / "learn" / f"{CAN}-ap.json"
    content = read_json(file)
    content["runs"][1]["models"] = "bb"
    write_json(file, content)
    text = " ".join(report(read_evidence(paper)).split())
    assert "The models of Pick-Place, Sawyer were trained twice" in text


def test_a_goal_that_is_just_met_is_met(tmp_path: Path) -> None:
    rates = [0.97, 0.98, 0.98, 0.98, 0.99]
    assert np.mean(rates) < 0.98  # as floats
    learned(tmp_path, CAN, "lfr", {"sparse": [round(100 * rate) for rate in rates]})
    runs = [
        replace(run, zero_shot=rate)
        for run, rate in zip(read_evidence(tmp_path).of(CAN, "lfr", "sparse"), rates, strict=True)
    ]
    assert steps_to_goal(runs, 0.98) == 0


def test_what_takes_no_reward_has_one_row_in_short(paper: Path) -> None:
    table = short_table(read_evidence(paper))
    assert len(cells(table, "BC+RNN")) == len(cells(table, "LfR, sparse")) == 1
    assert "BC+RNN, " not in table


def test_a_linear_map_stands_beside_g_of_its_own_seeds(tmp_path: Path) -> None:
    zero_shot(tmp_path, CAN, {"mapped": [80, 90, 0, 0, 0], "linear": [100, 98]})
    zero_shot(tmp_path, LIFT, {"mapped": [80, 90]})
    (line,) = findings(read_evidence(tmp_path)).splitlines()
    assert "linear map in G's place" in line
    assert "Pick-Place, Sawyer: 99.0 [" in line
    assert ", G 85.0 [" in line
    assert "is above G on 1 of 1 task: " in line
    zero_shot(tmp_path, LIFT, {"mapped": [80, 90], "linear": [85, 86], "no_cycle": [3]})
    linear, cycle = findings(read_evidence(tmp_path)).splitlines()
    assert "is above G on 1, not told apart from G on 1 of 2 tasks: " in linear
    assert "without the cycle loss**" in cycle
    assert "is below G on 1 of 1 task: Lift, Panda: 3.0 [" in cycle


def test_a_figure_is_shown_once_it_compares_something(paper: Path) -> None:
    learned(paper, CAN, "wrong_task", {"sparse": [3, 4, 5]})
    text = report(read_evidence(paper))
    assert "(questions.svg)" in text
    assert "(ablations.svg)" not in text
