"""How far the whole of `dvc repro` is, as its stages begin."""

import json
from pathlib import Path

from pipeline._repro import Plan, expected, stages

SECONDS = {"record@a": 100.0, "pack@a": 10.0, "skills@a": 300.0, "transfer@a": 200.0, "report": 0.0}


def running(stage: str) -> str:
    return f"Running stage '{stage}':\n"


def test_time_left_in_the_proportion_that_stages_have_taken_here() -> None:
    plan = Plan(SECONDS)
    assert plan.see("'data/x.dvc' didn't change, skipping\n", 0.0) is None
    first = plan.see(running("record@a"), 0.0)
    assert first == "[1 of 5] record@a: about 2 min; about 10 min left for the whole"
    assert plan.see("> python -m pipeline.record\n", 1.0) is None
    # It took twice as long as foreseen, so everything will; the next one did not change.
    assert plan.see("Stage 'pack@a' didn't change, skipping\n", 200.0) is None
    third = plan.see(running("skills@a"), 200.0)
    assert third == "[3 of 5] skills@a: about 10 min; about 17 min left for the whole"
    fourth = plan.see(running("transfer@a"), 200.0 + 200.0)  # faster now: 400 s for 400
    assert fourth == "[4 of 5] transfer@a: about 3 min; about 3 min left for the whole"
    assert plan.see(running("report"), 700.0) == "[5 of 5] report"


def test_nothing_is_known_of_a_stage_without_results(tmp_path: Path) -> None:
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "panda.json").write_text(json.dumps({"seconds": 12.5}))
    assert expected("skills@panda", tmp_path) == 12.5
    assert expected("skills@sawyer", tmp_path) == 0.0
    assert expected("report", tmp_path) == 0.0


def test_a_stage_that_dvc_has_in_its_cache_is_done() -> None:
    plan = Plan(SECONDS)
    cached = "Stage 'record@a' is cached - skipping run, checking out outputs\n"
    assert plan.see(cached, 0.0) is None
    assert (plan.see(running("pack@a"), 5.0) or "").startswith("[2 of 5] pack@a: about 10 s")


def test_stages_are_dvcs() -> None:
    assert {
        "skills@panda-joint_position",
        "transfer@s3-ur5e-joint_position-stack-lfr",
        "report",
    } <= set(stages())
