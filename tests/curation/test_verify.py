"""Each thing that can be wrong is found, in its place; a sound dataset has no finding."""

import json
import re
import shutil
from pathlib import Path

import pytest

from lfr import cli
from lfr.curation import edit
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding
from lfr.curation.verify import Report, verify_dataset
from lfr.data.episode import ACTION, STATE
from lfr.errors import DataError

from . import made_up
from .broken import BROKEN, EPISODES, column, cut, feature, info, stats


def test_a_sound_dataset_has_no_finding(sound: Path) -> None:
    report = verify_dataset(sound)
    assert report.findings == ()
    assert (report.episodes, report.frames, report.not_checked) == (5, 55, ())


def test_what_was_not_looked_at_is_said(sound: Path, tmp_path: Path) -> None:
    alone = shutil.copytree(sound, tmp_path / "alone")
    report = verify_dataset(alone)
    assert report.findings == ()
    assert report.not_checked == ("logs (not there; --logs DIR)",)
    assert verify_dataset(alone, sound.parent.parent / "logs/panda-lift").not_checked == ()
    with pytest.raises(DataError, match="no such folder of logs"):
        verify_dataset(alone, tmp_path / "nowhere")


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_is_found_in_its_place(dataset: Path, name: str) -> None:
    damage, check, severity, shown = BROKEN[name]
    damage(dataset)
    findings = verify_dataset(dataset).findings
    lines = [str(finding) for finding in findings]
    assert any(
        (finding.check, finding.severity) == (check, severity) and re.search(shown, line)
        for finding, line in zip(findings, lines, strict=True)
    ), "\n".join(lines)
    assert all("\n" not in line for line in lines)
    for finding in findings:
        assert list(finding.episodes) == sorted(set(finding.episodes))
        assert all(type(episode) is int for episode in finding.episodes)
        assert finding.episode is None or finding.episode in finding.episodes


def test_one_value_changed_is_found_by_its_statistics(dataset: Path) -> None:
    """Within every range and finite: only what was computed from it tells."""
    column("data/chunk-000/file-000.parquet", "action", lambda v: v[20].__setitem__(1, 0.999))(
        dataset
    )
    findings = verify_dataset(dataset).findings
    assert {finding.check for finding in findings} == {"statistics"}
    assert {finding.episode for finding in findings} == {None, 1}


def test_a_dataset_by_lerobot_has_the_known_finding_alone(by_lerobot: Path) -> None:
    """Its quantiles are averages of the episodes'; nothing else is held against it."""
    report = verify_dataset(by_lerobot)
    (finding,) = report.findings
    assert finding.check == "averaged-quantiles"
    assert finding.severity == "warning"
    assert "action/q01" in str(finding.column)
    assert "observation.state/q01" in str(finding.column)
    assert report.not_checked == ("logs (the episodes name none)",)


def test_every_type_that_lerobot_records_is_known(tmp_path: Path) -> None:
    path = made_up.record_every_kind(tmp_path / "kinds")
    assert len(list((path / "data").rglob("*.parquet"))) > 1
    report = verify_dataset(path)
    assert not report.errors, report.errors
    assert {f.check for f in report.findings} <= {"averaged-quantiles", "constant", "frozen"}
    edit.delete_episodes(path, [1], tmp_path / "edited")
    assert verify_dataset(tmp_path / "edited").findings == ()
    before, after = (Contents.open(each) for each in (path, tmp_path / "edited"))
    for key in ("observation.pose", "observation.note", "observation.images.eye"):
        kept = [*range(30), *range(32, 80)]
        assert (
            after.table([key])[key].to_pylist() == before.table([key])[key].take(kept).to_pylist()
        )


def test_what_lerobot_has_edited_has_no_errors(tmp_path: Path) -> None:
    """It numbers episodes and rows anew, and leaves the statistics of these as they were."""
    from lerobot.datasets import LeRobotDataset
    from lerobot.datasets.dataset_tools import delete_episodes, merge_datasets

    # LeRobot 0.6.1 cannot edit a dataset with a feature of two dimensions
    path = made_up.record_every_kind(tmp_path / "kinds", without="observation.pose")
    whole = LeRobotDataset("theirs/kinds", root=path)
    rest = delete_episodes(whole, [0], output_dir=tmp_path / "rest", repo_id="theirs/rest")
    merge_datasets([whole, rest], output_repo_id="theirs/both", output_dir=tmp_path / "both")
    for name in ("rest", "both"):
        report = verify_dataset(tmp_path / name)
        assert not report.errors, report.errors
        assert any(f.column == "index/max" or f.column == "index/min" for f in report.warnings)


def test_a_quantile_that_is_no_average_is_an_error(by_lerobot: Path, tmp_path: Path) -> None:
    dataset = shutil.copytree(by_lerobot, tmp_path / "theirs")
    stats(lambda s: s["action"]["q01"].__setitem__(0, 0.0))(dataset)
    errors = verify_dataset(dataset).errors
    assert [error.column for error in errors] == ["action/q01"]


def test_other_projects_names_have_no_ranges(by_lerobot: Path, tmp_path: Path) -> None:
    """Metres for us, perhaps degrees for them."""
    dataset = shutil.copytree(by_lerobot, tmp_path / "theirs")
    info(features={**json.loads((dataset / "meta/info.json").read_text())["features"]})(dataset)
    assert not [f for f in verify_dataset(dataset).findings if f.check == "range"]


def test_who_names_no_actions_at_all_leaves_nothing_out(sound: Path, tmp_path: Path) -> None:
    """LeRobot's recorder for reinforcement learning names actions alone, its evaluation neither."""
    for number, unnamed in enumerate(([STATE], [ACTION, STATE])):
        path = shutil.copytree(sound, tmp_path / str(number))
        for key in unnamed:
            feature(key, names=None)(path)
        assert not verify_dataset(path).findings
    feature(STATE, names=["all of them"])(path)
    assert {one.column for one in verify_dataset(path).findings} == {STATE}


def test_a_killed_recording_by_lerobot_is_found(tmp_path: Path) -> None:
    """Never finalized: the Parquet files have no footers (lerobot issue 3522)."""
    import numpy as np
    from lerobot.datasets import LeRobotDataset

    features = {"action": {"dtype": "float32", "shape": (2,), "names": ["left", "right"]}}
    recorded = LeRobotDataset.create("theirs/killed", 30, features, root=tmp_path / "killed")
    for _ in range(12):
        recorded.add_frame({"action": np.zeros(2, np.float32), "task": "Wait."})
    recorded.save_episode()
    shutil.copytree(tmp_path / "killed", tmp_path / "left")
    recorded.finalize()
    errors = verify_dataset(tmp_path / "left").errors
    assert any(error.file.startswith("data/") for error in errors)
    assert any("Parquet" in error.message for error in errors)


def test_what_is_no_dataset_at_all(tmp_path: Path, dataset: Path) -> None:
    with pytest.raises(DataError, match="no such dataset"):
        verify_dataset(tmp_path / "absent")
    (tmp_path / "empty").mkdir()
    with pytest.raises(DataError, match="not a LeRobot dataset"):
        verify_dataset(tmp_path / "empty")
    info(codebase_version="v2.1")(dataset)
    with pytest.raises(DataError, match=r"by its name alone.*found v2.1, expected v3.0"):
        verify_dataset(dataset)


def test_nothing_is_written(sound: Path) -> None:
    before = {p: p.stat().st_mtime_ns for p in sound.rglob("*")}
    verify_dataset(sound)
    assert {p: p.stat().st_mtime_ns for p in sound.rglob("*")} == before


@pytest.fixture(scope="module")
def exit_codes(sound: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[Path, int]:
    folder = tmp_path_factory.mktemp("exit")
    paths = [shutil.copytree(sound, folder / name) for name in ("sound", "warned", "wrong")]
    column(EPISODES, "seed", lambda v: v.__setitem__(2, 1))(paths[1])
    cut(EPISODES, 0.5)(paths[2])
    return {**dict(zip(paths, (0, 0, 1), strict=True)), folder: 2}


def test_exit_codes_and_the_last_line(
    exit_codes: dict[Path, int], capsys: pytest.CaptureFixture[str]
) -> None:
    last = []
    for path, code in exit_codes.items():
        assert cli.main(["verify", str(path)]) == code, path
        printed = capsys.readouterr()
        last.append((printed.out or printed.err).splitlines()[-1])
    assert "sound: 5 episodes, 55 frames: no errors, no warnings" in last[0]
    assert "no errors, 1 warning;" in last[1]
    assert re.search(r"wrong: .* [1-9]\d* errors?, ", last[2])
    assert last[3].startswith("lfr: error: not a LeRobot dataset")


def test_json_says_the_same(
    exit_codes: dict[Path, int], capsys: pytest.CaptureFixture[str]
) -> None:
    for path, code in list(exit_codes.items())[:3]:
        assert cli.main(["verify", str(path), "--json"]) == code
        content = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
        report = verify_dataset(path)
        assert (content["errors"], content["warnings"]) == (
            len(report.errors),
            len(report.warnings),
        )
        assert [f["check"] for f in content["findings"]] == [f.check for f in report.findings]
        assert all(set(Finding.__dataclass_fields__) == set(f) for f in content["findings"])


def test_a_report_is_one_line(tmp_path: Path) -> None:
    finding = Finding("range", "out of\nits range", file="data", row=3, found=float("nan"))
    report = Report(tmp_path, (finding,), 1, 2)
    assert str(report).endswith("1 episodes, 2 frames: 1 error, no warnings")
    assert (
        json.loads(json.dumps(report.as_json(), allow_nan=False))["findings"][0]["found"] == "nan"
    )


@pytest.mark.parametrize("wrong", [3, "x", [[1], [2, 3]], {}, None])
def test_whatever_stands_in_the_json_is_no_traceback(dataset: Path, wrong: object) -> None:
    """In place of every value of info.json, and of two of its features."""
    file = dataset / "meta/info.json"
    sound = json.loads(file.read_text())
    places = [(key,) for key in sound if key != "codebase_version"]
    for name in ("action", "observation.images.agentview"):
        places += [("features", name, key) for key in sound["features"][name]]
    for place in places:
        at = content = json.loads(json.dumps(sound))
        for key in place[:-1]:
            at = at[key]
        at[place[-1]] = wrong
        file.write_text(json.dumps(content))
        assert json.dumps(verify_dataset(dataset).as_json(), allow_nan=False), place


@pytest.mark.parametrize(
    "names",
    [["l", "r"], [["l", "r"]], {"motors": ["l", "r"]}, {"l": 0, "r": 1}, {"a": ["l"], "b": ["r"]}],
)
def test_names_have_several_forms(names: object) -> None:
    from lfr.data.features import names_of

    assert len(names_of({"names": names})) == 2
    assert names_of({"names": None}) == names_of({}) == names_of({"names": 3}) == []
