"""The cards: current, complete, and such as the Hub takes."""

import io
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml

from lfr.data.episode import ACTION, DONE, IMAGES, REWARD, STATE, SUCCESS, features_of
from lfr.demos.recorder import RecordParams
from lfr.embodiments import embodiment, embodiments
from lfr.errors import DataError
from lfr.hub import card_command
from lfr.hub.card_command import everything
from lfr.hub.dataset_card import dataset_card
from lfr.hub.dataset_facts import Column, DatasetFacts, read_facts, read_making
from lfr.hub.departures import departures
from lfr.hub.dimensions import rows
from lfr.hub.model_facts import read_models
from lfr.hub.picture import FRAMES, picture
from lfr.params import read_section
from lfr.seeds import use_of_seed
from lfr.tasks import TASKS
from tests.data import made_up

from .conftest import IMAGE_SIZE, LENGTHS
from .server import header_errors

ROOT = Path(__file__).parent.parent.parent
RESULTS = ROOT / "results"
DATASETS = [path.stem for path in sorted((RESULTS / "pack").glob("*.json"))]
MODELS = [
    f"{stage}-{path.stem}"
    for stage in ("skills", "mapping", "transfer")
    for path in sorted((RESULTS / stage).glob("*.json"))
]
datasets = pytest.mark.parametrize("name", DATASETS)
models = pytest.mark.parametrize("title", MODELS)


def read(*parts: str) -> Any:
    return json.loads(RESULTS.joinpath(*parts).with_suffix(".json").read_text())


def header(text: str) -> Any:
    block = re.match(r"---\n(.*?)\n---\n", text, re.DOTALL)
    assert block
    return yaml.safe_load(block[1])


def facts_without_data(name: str) -> DatasetFacts:
    """What a dataset's facts must be, by the results and the code, not by its files."""
    robot, _, task = name.rpartition("-")
    record, pack = read("record", name), read("pack", name)
    schema = features_of(embodiment(robot), TASKS[task])
    columns = [Column(f.key, f.dtype, f.shape, f.names or ()) for f in schema.values()]
    cameras = read_section(RecordParams, "record", ROOT / "params.yaml").cameras
    assert pack["cameras"] == [camera.name for camera in cameras]
    for camera in cameras:
        shape, names = (camera.height, camera.width, 3), ("height", "width", "channels")
        columns.append(Column(f"{IMAGES}{camera.name}", "video", shape, names, "av1"))
    for key in ("timestamp", "frame_index", "episode_index", "index", "task_index"):
        columns.append(Column(key, "float32" if key == "timestamp" else "int64", (1,), ()))
    length, seeds = record["length"], record["seeds"]
    return DatasetFacts(
        name, robot, (task,), (TASKS[task].instruction,), 20, pack["episodes"], pack["frames"],
        (length["min"], length["median"], length["max"]), pack["successes"],
        (seeds["first"], seeds["last"]), pack["bytes"], tuple(columns),
    )  # fmt: skip


@datasets
def test_dataset_cards_are_current(name: str) -> None:
    facts = facts_without_data(name)
    shown = f"{name}.jpg" if facts.cameras else None
    expected = dataset_card(facts, read_making(facts, RESULTS), picture=shown)
    assert (ROOT / "dataset_cards" / f"{name}.md").read_text() == expected, "run `lfr card`"
    if shown:
        assert (ROOT / "dataset_cards" / shown).stat().st_size < 30_000


@models
def test_model_cards_are_current(title: str) -> None:
    """As far as the results go; the rest is in the models' own config.json."""
    text = (ROOT / "model_cards" / f"{title}.md").read_text()
    stage, _, name = title.partition("-")
    noted = read(stage, name)
    assert f"git checkout {noted['provenance']['revision']}" in text, "run `lfr card`"
    assert f"dvc repro {stage}@{name}" in text
    tallies = list(found(noted, "own_arm")) if stage == "skills" else []
    tallies += list(read("chain", name)["zero_shot"].values()) if stage == "mapping" else []
    tallies += [s for run in read("evaluate", name)["runs"] for s in run["success"].values()
                ] if stage == "transfer" else []  # fmt: skip
    assert tallies
    for tally in tallies:
        assert f"{tally['successes']} of {tally['episodes']} (" in text
    for group in found(noted, "datasets"):
        for dataset, digest in group.items():
            assert f"| `{dataset}` | `{digest}` |" in text


def found(value: Any, key: str) -> list[Any]:
    """Everything under this key, at any depth."""
    if not isinstance(value, dict):
        return []
    here = [value[key]] if isinstance(value.get(key), dict) else []
    return here + [one for part in value.values() for one in found(part, key)]


def test_there_is_a_card_for_each_and_no_other() -> None:
    names = {"dataset_cards": DATASETS, "model_cards": MODELS}
    for folder, expected in names.items():
        assert sorted(p.stem for p in (ROOT / folder).glob("*.md")) == sorted(expected)


@pytest.mark.slow
@pytest.mark.skipif(not (ROOT / "data" / "lerobot").is_dir(), reason="no datasets here")
def test_cards_and_pictures_are_those_of_the_data(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from lfr import cli

    monkeypatch.chdir(ROOT)
    assert cli.main(["card", "--check"]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("folder", ["dataset_cards", "model_cards"])
def test_the_hub_takes_the_headers(folder: str) -> None:
    for file in (ROOT / folder).glob("*.md"):
        given = header(file.read_text())
        assert header_errors(given, folder.removesuffix("_cards")) == []
        if folder == "dataset_cards":
            robot, _, task = file.stem.rpartition("-")
            assert {"LeRobot", robot, task} <= set(given["tags"])
            assert given["configs"][0]["data_files"] == "data/*/*.parquet"


@datasets
def test_a_card_says_what_the_issue_of_cards_asks(name: str) -> None:
    text = (ROOT / "dataset_cards" / f"{name}.md").read_text()
    record = read("record", name)
    body = embodiment(name.rpartition("-")[0])
    assert f"`{body.controller.stock_name}`" in text
    assert use_of_seed(record["seeds"]["last"]) == "demonstration"
    assert f"{record['seeds']['first']} to {record['seeds']['last']}" in text
    assert f"{100 * (1 - record['failures'] / record['attempts']):.1f} %" in text
    assert all(line in text for line in departures(body.robot))
    load = re.search(r"## Load\n\n```python\n(.*?)```", text, re.DOTALL)
    assert load
    assert len(load[1].splitlines()) == 3
    compile(load[1], name, "exec")


@pytest.mark.parametrize("robot", [body.name for body in embodiments()])
@pytest.mark.parametrize("task", TASKS)
def test_every_dimension_is_explained(robot: str, task: str) -> None:
    body = embodiment(robot)
    for space in (TASKS[task].observation, body.action):
        shown = list(rows(space))
        assert all(about for *_, about in shown)
        named = " ".join(names.strip("`") for names, *_ in shown).split()
        assert len(named) - sum(" ." in names for names, *_ in shown) == space.size


def test_what_an_action_of_1_asks_of_each_joint() -> None:
    body = embodiment("panda-joint_position")
    units = {names: unit for names, unit, *_ in rows(body.action)}
    scale = zip(body.action.names, body.action_scale, strict=False)
    assert units == {**{f"`{name}`": f"{value:g} rad" for name, value in scale}, "`gripper`": ""}


def test_symmetries_are_those_of_the_documents() -> None:
    text = (ROOT / "docs" / "data.md").read_text()
    documented = dict(re.findall(r"`(\w+_yaw)` \(k = (\d)", text))
    yaws = [q for t in TASKS.values() for q in t.environment.quantities if q.name.endswith("_yaw")]
    assert documented == {yaw.name: str(yaw.fold) for yaw in yaws}
    for yaw in yaws:
        assert f"cosine and sine of {yaw.fold} times" in yaw.about


def test_facts_are_counted_in_the_files(dataset: Path) -> None:
    facts = read_facts(dataset)
    assert (facts.robot, facts.tasks, facts.fps) == ("panda", ("lift",), 20)
    assert (facts.episodes, facts.frames) == (len(LENGTHS), sum(LENGTHS))
    assert facts.lengths == (min(LENGTHS), np.median(LENGTHS), max(LENGTHS))
    assert facts.seeds == (0, len(LENGTHS) - 1)
    assert facts.successes == len(LENGTHS)
    assert facts.size == sum(f.stat().st_size for f in dataset.rglob("*") if f.is_file())
    shapes = {column.key: column.shape for column in facts.columns}
    assert shapes[STATE] == (len(made_up.STATE_NAMES),)
    assert shapes[REWARD] == shapes[SUCCESS] == shapes[DONE] == (1,)
    assert shapes[f"{IMAGES}agentview"] == (IMAGE_SIZE, IMAGE_SIZE, 3)
    assert facts.cameras[0].codec == "av1"


def test_a_dataset_by_others_has_a_card_without_our_results(dataset: Path) -> None:
    facts = replace(
        read_facts(dataset), robot="so101", tasks=(), seeds=None, successes=None, noted=()
    )
    text = dataset_card(facts, repo_id="someone/else")
    assert header_errors(header(text), "dataset") == []
    assert 'LeRobotDataset("someone/else"' in text
    assert "robosuite" not in header(text)["tags"]
    assert "## Rebuild" not in text
    assert "license" not in header(text)  # theirs to give
    assert "taken over all values" not in text
    assert "`meta/episodes`" not in text
    given = dataset_card(facts, repo_id="someone/else", license="cc-by-4.0")
    assert header(given)["license"] == "cc-by-4.0"


def test_names_of_ours_in_a_layout_of_others_are_not_explained(dataset: Path) -> None:
    """Their `action` and `gripper` may be degrees."""
    facts = read_facts(dataset)
    assert "0.05 m" in dataset_card(facts)
    names = ("shoulder", "elbow", "gripper")
    columns = [replace(c, names=names, shape=(3,)) if c.key == ACTION else c for c in facts.columns]
    text = dataset_card(replace(facts, columns=tuple(columns)))
    assert "`shoulder`, `elbow`, `gripper`" in text
    for claim in ("0.05 m", "base frame", "positive closes", "robosuite"):
        assert claim not in text


def test_a_merged_dataset_has_the_gaps_of_its_parts(dataset: Path, tmp_path: Path) -> None:
    """One part knows no seeds, and another task; the card says what holds of all."""
    copy = shutil.copytree(dataset, tmp_path / "merged")
    file = next((copy / "meta/episodes").rglob("*.parquet"))
    table = pq.read_table(file)
    for name, value in (("seed", None), ("success", None), ("task_name", None)):
        at = table.column_names.index(name)
        values = [value, *table[name].to_pylist()[1:]]
        table = table.set_column(at, name, pa.array(values, table.schema.field(at).type))
    pq.write_table(table, file)
    facts = read_facts(copy)
    assert (facts.tasks, facts.seeds, facts.successes) == (("lift",), None, None)
    text = dataset_card(replace(facts, instructions=("Lift.", "Stack."), tasks=("lift", "stack")))
    assert "3 episodes of 2 tasks, *Lift.*; *Stack.*" in text
    assert "One arm and one task" not in text
    assert {"lift", "stack"} <= set(header(text)["tags"])


@pytest.mark.parametrize("key", ["frames", "seeds"])
def test_results_of_another_dataset_are_refused(key: str, tmp_path: Path) -> None:
    facts = facts_without_data(DATASETS[0])
    record, pack = read("record", facts.name), read("pack", facts.name)
    record[key] = {"first": 3, "last": 4} if key == "seeds" else record[key] + 1
    for stage, noted in (("record", record), ("pack", pack)):
        (tmp_path / stage).mkdir()
        (tmp_path / stage / f"{facts.name}.json").write_text(json.dumps(noted))
    with pytest.raises(DataError, match=f"another dataset.*{key}"):
        read_making(facts, tmp_path)


def test_results_of_other_models_are_refused(models: Path, tmp_path: Path) -> None:
    noted = {"models": {"lift+stack": {"datasets": {"sawyer-lift": "1" * 64}}}}
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "sawyer.json").write_text(json.dumps(noted))
    with pytest.raises(DataError, match="other models"):
        read_models(models, tmp_path)


def test_the_picture_shows_the_first_episode_from_first_to_last(dataset: Path) -> None:
    from PIL import Image

    strip = np.asarray(Image.open(io.BytesIO(picture(dataset, f"{IMAGES}agentview"))), float)
    assert strip.shape == (IMAGE_SIZE, FRAMES * IMAGE_SIZE, 3)
    for place, image in enumerate(np.split(strip, FRAMES, axis=1)):
        frame = place * (LENGTHS[0] - 1) // (FRAMES - 1)
        expected = made_up.picture(0, frame, IMAGE_SIZE).astype(float)
        other = made_up.picture(0, frame + 2, IMAGE_SIZE).astype(float)
        assert np.abs(image - expected).mean() < 5 < np.abs(image - other).mean()


def test_cards_are_written_and_checked(
    dataset: Path, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from lfr import cli

    command = ["card", str(dataset), str(models), "--results", "none", "--to", str(tmp_path)]
    assert cli.main([*command, "--check"]) == 1
    assert list(tmp_path.iterdir()) == []
    assert cli.main(command) == 0
    files = {f.relative_to(tmp_path).as_posix() for f in tmp_path.rglob("*") if f.is_file()}
    assert files == {"dataset_cards/panda-lift.md", "dataset_cards/panda-lift.jpg",
                     "model_cards/skills-sawyer.md"}  # fmt: skip
    assert cli.main([*command, "--check"]) == 0
    (tmp_path / card_command.DATASETS / "panda-lift.md").write_text("old")
    capsys.readouterr()
    assert cli.main([*command, "--check"]) == 1
    assert "panda-lift.md: out of date" in capsys.readouterr().err


def test_without_paths_studies_are_left_alone(tmp_path: Path) -> None:
    places = [
        "transfer/a-lfr",
        "skills/a",
        "external-skills/b",
        "mapping/a",
        "studies/a",
        "study-policies/a-sac",
    ]
    for place in places:
        (tmp_path / "models" / place).mkdir(parents=True)
    (tmp_path / "data/robot-task").mkdir(parents=True)
    found = everything(tmp_path / "data", tmp_path / "models")
    names = [path.relative_to(tmp_path).as_posix() for path in found]
    assert names == ["data/robot-task", "models/external-skills/b", "models/mapping/a",
                     "models/skills/a", "models/transfer/a-lfr"]  # fmt: skip
