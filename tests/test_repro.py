"""`dvc repro` of several stages at a time: their order, and a project that DVC itself judges."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipeline._dag import dvc_dag, stages_before
from pipeline._plan import Plan
from pipeline._repro import changed_stages, expected, to_run
from tests.processes import ended

ROOT = Path(__file__).parent.parent
BEFORE = {"record@a": (), "record@b": (), "pack@a": ("record@a",), "pack@b": ("record@b",),
          "skills": ("pack@a", "pack@b"), "report": ("skills", "pack@a")}  # fmt: skip
SECONDS = {"record@a": 10.0, "record@b": 40.0, "pack@a": 20.0, "pack@b": 20.0, "skills": 100.0}


def begun(plan: Plan, now: float) -> list[str]:
    return list(iter(lambda: plan.begin(now), None))


def test_a_stage_begins_once_those_before_it_have_ended_the_longest_way_first() -> None:
    plan = Plan(BEFORE, SECONDS, at_once=2)
    assert begun(plan, 0.0) == ["record@b", "record@a"]
    plan.end("record@a", 10.0)
    assert begun(plan, 10.0) == ["pack@a"]
    plan.end("pack@a", 30.0)
    assert begun(plan, 30.0) == []
    plan.end("record@b", 40.0)
    assert begun(plan, 40.0) == ["pack@b"]
    plan.end("pack@b", 60.0)
    assert begun(plan, 60.0) == ["skills"]
    plan.end("skills", 160.0)
    assert begun(plan, 160.0) == ["report"]
    assert not plan.done
    assert plan.end("report", 161.0) == 1.0
    assert plan.done


def test_no_more_at_once_than_asked() -> None:
    plan = Plan(dict.fromkeys("abcd", ()), {}, at_once=3)
    assert len(begun(plan, 0.0)) == 3


def test_time_left_in_the_proportion_that_stages_have_taken_here() -> None:
    plan = Plan(BEFORE, SECONDS, at_once=2)
    # both records and packs are done after 60 s, as above, then skills alone
    assert plan.left(0.0) == pytest.approx(160.0)
    begun(plan, 0.0)
    assert plan.left(5.0) == pytest.approx(155.0)
    plan.end("record@a", 20.0)  # twice as long as foreseen, so everything will take
    begun(plan, 20.0)
    assert plan.left(20.0) == pytest.approx(2 * 160.0 - 20.0)
    plan.end("pack@a", 20.0, ran=False)  # found done, which says nothing of the machine
    assert plan.left(20.0) == pytest.approx(2 * 160.0 - 20.0)


def test_one_at_a_time_takes_the_sum() -> None:
    assert Plan(BEFORE, SECONDS, at_once=1).left(0.0) == pytest.approx(sum(SECONDS.values()))


def test_nothing_is_known_of_a_stage_without_results(tmp_path: Path) -> None:
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "panda.json").write_text(json.dumps({"seconds": 12.5}))
    assert expected("skills@panda", tmp_path) == 12.5
    assert expected("skills@sawyer", tmp_path) == 0.0
    assert expected("report", tmp_path) == 0.0
    assert Plan(BEFORE, {}, at_once=2).left(0.0) == 0.0


def test_what_has_changed_and_all_that_depends_on_it() -> None:
    assert to_run(BEFORE, ["pack@b"]) == {
        "pack@b": set(), "skills": {"pack@b"}, "report": {"skills"},
    }  # fmt: skip
    assert to_run(BEFORE, []) == {}


def test_the_graph_is_the_main_jobs() -> None:
    before = stages_before(dvc_dag(ROOT))
    assert "pack@panda-joint_position-lift" in before["skills@sawyer-joint_position"]
    assert "mapping@s3-ur5e-joint_position-stack" in before[
        "transfer@s3-ur5e-joint_position-stack-lfr"
    ]  # fmt: skip
    assert before["record@panda-joint_position-lift"] == set()


# Each of `meet` ends only once the other has begun; `sum` takes what both have written.
PROJECT = """
stages:
  meet:
    matrix: {me: [one, two]}
    cmd: python meet.py ${item.me}
    deps: [meet.py, input]
    outs: ["out/${item.me}"]
  sum:
    cmd: cat out/one out/two > sum
    deps: [out/one, out/two]
    outs: [sum]
  apart:
    cmd: python apart.py
    deps: [apart.py]
    outs: [apart]
"""
MEET = """
import sys, time
from pathlib import Path
me = sys.argv[1]
Path(me).touch()
for _ in range(600):
    if Path("one").exists() and Path("two").exists():
        break
    time.sleep(0.1)
else:
    sys.exit("alone")
Path("out").mkdir(exist_ok=True)
Path("out", me).write_text(me + Path("input").read_text())
"""


def repro(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "pipeline._repro", *words], cwd=folder, capture_output=True,
        text=True, check=False, env=os.environ | {"PYTHONPATH": str(ROOT)}, timeout=300,
    )  # fmt: skip


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("project")
    for command in (["git", "init", "-q"], [sys.executable, "-m", "dvc", "init", "-q"]):
        subprocess.run(command, cwd=folder, check=True)
    (folder / "dvc.yaml").write_text(PROJECT)
    (folder / "meet.py").write_text(MEET)
    (folder / "apart.py").write_text("open('apart', 'w').write('apart')")
    (folder / "input").write_text(" and ")
    return folder


def test_stages_run_side_by_side_and_dvc_finds_them_done(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = repro(project)
    assert first.returncode == 0, first.stdout + first.stderr
    assert "4 of 4 stages to run, 2 at a time" in first.stdout
    assert (project / "sum").read_text() == "one and two and "
    assert json.loads((project / "results/repro.json").read_text())["stages"] == 4
    monkeypatch.chdir(project)
    assert changed_stages() == []
    assert "all 4 stages are up to date" in repro(project).stdout

    (project / "input").write_text(" or ")
    again = repro(project, "--at-once", "1")  # they have met already
    assert "3 of 4 stages to run, 1 at a time" in again.stdout
    assert "apart" not in again.stdout
    assert (project / "sum").read_text() == "one or two or "
    assert changed_stages() == []


def test_a_stage_that_fails_is_the_end_and_says_why(project: Path) -> None:
    (project / "apart.py").write_text("import sys; sys.exit('out of ideas')")
    found = repro(project)
    assert found.returncode == 2
    assert "    out of ideas" in found.stdout
    assert "apart failed; all that it printed is in work/repro/apart.log" in found.stderr
    assert "Traceback" not in found.stderr


def test_none_at_a_time_is_refused(project: Path) -> None:
    found = repro(project, "--at-once", "0")
    assert found.returncode == 2
    assert "--at-once: found 0, expected at least 1" in found.stderr


@pytest.mark.parametrize("shell", ["/bin/sh", "/bin/bash"])
def test_nothing_goes_on_where_it_is_killed(project: Path, shell: str) -> None:
    """Bash gives way to the last command that it runs; dash stays between DVC and the stage."""
    said = project / "said"
    code = "import os, time; open('said', 'w').write(str(os.getpid())); time.sleep(100)"
    # as the stages do (`lfr.program.run_stage`)
    (project / "apart.py").write_text(
        f"from lfr.program import end_with_parent; end_with_parent(); {code}"
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline._repro"], cwd=project, stdout=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(ROOT), "SHELL": shell},
    )  # fmt: skip
    for _ in range(600):
        if said.is_file() and said.read_text():
            break
        time.sleep(0.1)
    stage = int(said.read_text())
    process.send_signal(signal.SIGKILL)
    process.wait()
    for _ in range(300):
        if ended(stage):
            return
        time.sleep(0.1)
    pytest.fail("the stage outlives the program that has started it")
