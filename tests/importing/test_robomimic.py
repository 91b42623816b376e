"""LeRobotDataset opens what is imported; every row is held against the arrays that were written."""

import hashlib
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from lfr.artifacts import read_json
from lfr.cli import main
from lfr.data import frames as frame_files
from lfr.data.windows import read_dataset
from lfr.errors import DataError, LfrError, ParameterError
from lfr.importing.columns import action_names, object_parts
from lfr.importing.dataset import About, import_robomimic
from lfr.importing.features import Choice

from . import made_up

IMAGE_SIZE = 64
ORDER = ("demo_0", "demo_2", "demo_10")  # by number, not by name
CAMERA = "observation.images.agentview"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"


@pytest.fixture(scope="module")
def arrays() -> dict[str, dict[str, np.ndarray]]:
    return made_up.demos(IMAGE_SIZE)


@pytest.fixture(scope="module")
def source(arrays: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_up.write(tmp_path_factory.mktemp("robomimic") / "image.hdf5", arrays)


@pytest.fixture(scope="module")
def imported(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("lerobot") / "robomimic-lift"
    assert main(["import", str(source), "--to", str(out), "--simulator-states"]) == 0
    return out


def rot6d(quaternions: np.ndarray) -> np.ndarray:
    """By MuJoCo, whose quaternions begin with w."""
    import mujoco

    rows = []
    for x, y, z, w in quaternions:
        matrix = np.empty(9)
        mujoco.mju_quat2Mat(matrix, np.array([w, x, y, z]))
        rows.append(matrix.reshape(3, 3)[:, :2].T.ravel())
    return np.array(rows)


def test_every_row_is_the_files(imported: Path, arrays: dict[str, dict[str, np.ndarray]]) -> None:
    from lerobot.datasets import LeRobotDataset

    dataset = LeRobotDataset("lfr/robomimic-lift", root=imported, video_backend="pyav")
    assert (dataset.num_episodes, dataset.fps) == (3, 20)
    at = 0
    for episode, name in enumerate(ORDER):
        demo = arrays[name]
        obs = {key.removeprefix("obs/"): values for key, values in demo.items()}
        state = [obs["robot0_eef_pos"], rot6d(obs["robot0_eef_quat"]), obs["robot0_gripper_qpos"]]
        expected = {
            "observation.state": np.concatenate(state, axis=1),
            "observation.environment_state": obs["object"],
            "observation.joint_position": obs["robot0_joint_pos"],
            "action": demo["actions"],
            "next.reward": demo["rewards"],
            "next.success": demo["rewards"] == 1,
            "simulator_state": demo["states"],
        }
        for t in range(len(demo["actions"])):
            row = dataset[at + t]
            for key, values in expected.items():
                np.testing.assert_allclose(
                    np.asarray(row[key]), values[t].astype(np.float32), atol=1e-6, err_msg=key
                )
            assert (row["episode_index"], row["frame_index"]) == (episode, t)
            assert row["task"] == "lift the cube"
            assert bool(row["next.done"]) == (t == len(demo["actions"]) - 1)
            # this frame, not its neighbour, which is 10 levels of red away
            seen = row[CAMERA].permute(1, 2, 0).numpy() * 255
            assert abs(seen[..., 0].mean() - demo["obs/agentview_image"][t][..., 0].mean()) < 4
        at += len(demo["actions"])
    assert dataset.num_frames == at


def test_simulator_states_keep_their_precision(imported: Path, arrays: Any) -> None:
    column = pq.read_table(imported / "data")["simulator_state"].to_pylist()
    expected = np.concatenate([arrays[name]["states"] for name in ORDER])
    np.testing.assert_array_equal(np.array(column), expected)


def test_every_dimension_is_named(imported: Path) -> None:
    info = read_json(imported / "meta/info.json")
    names = {key: feature["names"] for key, feature in info["features"].items()}
    axes = [f"robot0_eef_pos.{axis}" for axis in "xyz"]
    rotation = [f"robot0_eef_rot6d.{i}" for i in range(6)]
    fingers = ["robot0_gripper_qpos.0", "robot0_gripper_qpos.1"]
    assert names["observation.state"] == axes + rotation + fingers
    assert names["action"] == ["dx", "dy", "dz", "drx", "dry", "drz", "gripper"]
    assert names["observation.environment_state"][3:7] == [f"cube_quat.{a}" for a in "xyzw"]
    assert info["robot_type"] == "panda"
    for key, feature in info["features"].items():
        if feature["dtype"] != "video" and feature["names"]:
            assert [len(feature["names"])] == list(feature["shape"]), key


def test_an_episode_says_where_it_comes_from(imported: Path, source: Path) -> None:
    rows = pq.read_table(imported / EPISODES).to_pylist()
    assert [row["source_demo"] for row in rows] == list(ORDER)
    assert [row["masks"] for row in rows] == [["20_percent", "train"], ["valid"], ["train"]]
    models = [hashlib.sha256(f"<mujoco model='{name}'/>".encode()).hexdigest() for name in ORDER]
    assert [row["model_sha256"] for row in rows] == models
    digest = hashlib.sha256(source.read_bytes()).hexdigest()
    for row in rows:
        assert (row["source_file"], row["source_sha256"]) == ("image.hdf5", digest)
        assert (row["robot"], row["task_name"], row["success"]) == ("panda", "lift", True)
    about = read_json(imported / "meta/source.json")
    assert about["env_args"] == made_up.ENV_ARGS
    assert about["left_out"] == ["robot0_joint_vel"]


def test_lerobot_filters_by_the_mask(imported: Path) -> None:
    from lerobot.datasets import LeRobotDatasetMetadata

    meta = LeRobotDatasetMetadata("lfr/robomimic-lift", root=imported)
    assert meta.filter_episodes(lambda episode: "train" in episode["masks"]) == [0, 2]


def test_statistics_and_quantiles_are_those_of_all_rows(imported: Path, arrays: Any) -> None:
    """Quantiles by counting: a q-quantile has a fraction q of the values below it."""
    stats = read_json(imported / "meta/stats.json")["action"]
    rows = np.concatenate([arrays[name]["actions"] for name in ORDER])
    np.testing.assert_allclose(stats["mean"], rows.mean(axis=0), atol=1e-6)
    np.testing.assert_allclose(stats["std"], rows.std(axis=0), atol=1e-6)
    for name, q in {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}.items():
        below = (rows < np.array(stats[name]) - 1e-7).mean(axis=0)
        assert np.all(np.abs(below - q) <= 1 / len(rows)), name
    row = pq.read_table(imported / EPISODES).to_pylist()[1]
    np.testing.assert_allclose(row["stats/action/max"], arrays["demo_2"]["actions"].max(axis=0))
    assert row["stats/action/count"] == [7]


def test_training_reads_it(imported: Path) -> None:
    found = read_dataset(imported)
    assert (found.robot, found.task, found.fps, found.episodes) == ("panda", "lift", 20, 3)
    assert found.observations.shape == (sum(made_up.LENGTHS.values()), 11 + 10)
    assert found.successes.sum() == 3


def small(tmp_path: Path, **changes: Any) -> Path:
    """A file of states alone; changes are arrays of demo_2, None for one that is missing."""
    content = made_up.demos()
    for key, values in changes.items():
        key = key.replace("__", "/")
        if values is None:
            del content["demo_2"][key]
        else:
            content["demo_2"][key] = values
    return made_up.write(tmp_path / "low_dim.hdf5", content)


def test_a_mask_chooses_and_quaternions_may_stay(tmp_path: Path) -> None:
    out = tmp_path / "valid"
    arguments = ["import", str(small(tmp_path)), "--to", str(out), "--mask", "valid"]
    options = ["--quaternions", "keep", "--state", "robot0_eef_quat", "--environment"]
    assert main([*arguments, *options, "--robot", "mine", "--task", "push", "--fps", "10"]) == 0
    info = read_json(out / "meta/info.json")
    assert (info["total_episodes"], info["fps"], info["robot_type"]) == (1, 10, "mine")
    assert "observation.environment_state" not in info["features"]
    table = pq.read_table(out / "data")
    expected = made_up.demos()["demo_2"]["obs/robot0_eef_quat"].astype(np.float32)
    np.testing.assert_array_equal(np.array(table["observation.state"].to_pylist()), expected)


def test_success_may_be_told_otherwise(tmp_path: Path) -> None:
    dense = np.linspace(0, 0.7, 7)
    file = small(tmp_path, rewards=dense, dones=np.array([0, 0, 0, 0, 1, 1, 1]))
    for success, expected in (("done", [0, 0, 0, 0, 1, 1, 1]), ("last", [0, 0, 0, 0, 0, 0, 1])):
        out = tmp_path / success
        import_robomimic(file, out, Choice(success=success), mask="valid")
        assert pq.read_table(out / "data")["next.success"].to_pylist() == expected
    with pytest.raises(DataError, match="no demonstration succeeds; say with --success"):
        import_robomimic(file, tmp_path / "reward", mask="valid")
    assert not (tmp_path / "reward").exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"obs__object": None},
            r"an array is missing: .*demo_2/obs/object, found .*robot0_eef_pos",
        ),
        ({"rewards": None}, r"missing: .*demo_2/rewards.*dataset_states_to_obs"),
        ({"rewards": np.zeros(6)}, r"demo_2/rewards, found 6, expected 7"),
        ({"obs__object": np.zeros((7, 14))}, r"another size .*demo_2/obs/object, found 14"),
        ({"actions": np.zeros((7, 6))}, r"another size .*demo_2/actions, found \[6\]"),
        ({"obs__robot0_eef_quat": np.zeros((7, 4))}, r"no unit quaternion; --quaternions keep"),
        ({"obs__object": np.full((7, 10), np.nan)}, r"not finite: .*demo_2/obs/object.* frame 0"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(DataError, match=message):
        import_robomimic(small(tmp_path, **changes), tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["low_dim.hdf5"]


def test_an_observation_that_is_not_there_lists_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"found .*object \[10\].*, expected eef_pos"):
        import_robomimic(small(tmp_path), tmp_path / "out", Choice(state=("eef_pos",)))


def test_a_raw_file_is_told_how_to_get_observations(tmp_path: Path) -> None:
    raw = {
        name: {key: demo[key] for key in ("actions", "states")}
        for name, demo in made_up.demos().items()
    }
    file = made_up.write(tmp_path / "demo.hdf5", raw)
    with pytest.raises(DataError, match=r"dataset_states_to_obs"):
        import_robomimic(file, tmp_path / "out")


def test_a_file_cut_off_or_of_another_kind(tmp_path: Path) -> None:
    import h5py

    whole = small(tmp_path).read_bytes()
    (tmp_path / "cut.hdf5").write_bytes(whole[: len(whole) // 2])
    with h5py.File(tmp_path / "other.hdf5", "w") as other:
        other["observations"] = np.zeros(3)
    for name, message in (("cut", "cut off"), ("other", "not a robomimic file"), ("no", "missing")):
        with pytest.raises(DataError, match=message):
            import_robomimic(tmp_path / f"{name}.hdf5", tmp_path / "out")


def test_what_differs_from_the_file_is_not_given_the_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As if the disk had changed an action between writing and reading."""
    write = frame_files._arrow
    monkeypatch.setattr(
        frame_files,
        "_arrow",
        lambda values, type: write(values + 1 if values.shape[1:] == (7,) else values, type),
    )
    file = small(tmp_path)
    with pytest.raises(DataError, match=r"differs from its source.*column (observation|action)"):
        import_robomimic(file, tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["low_dim.hdf5"]


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    out.mkdir()
    (out / "thesis.tex").write_text("years of work")
    with pytest.raises(LfrError, match="is there already"):
        import_robomimic(small(tmp_path), out)
    assert (out / "thesis.tex").read_text() == "years of work"


def test_no_such_mask_and_no_rate(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"no such mask: .*found 20_percent, train, valid"):
        import_robomimic(small(tmp_path), tmp_path / "out", mask="test")
    file = made_up.write(tmp_path / "real.hdf5", made_up.demos(), {"env_name": "Real"}, {})
    with pytest.raises(ParameterError, match="give --fps"):
        import_robomimic(file, tmp_path / "out")
    import_robomimic(file, tmp_path / "out", about=About(robot="arm", fps=30))
    columns = pq.read_schema(tmp_path / "out" / EPISODES).names
    assert "masks" not in columns  # a column of empty lists has no type
    names = read_json(tmp_path / "out/meta/info.json")["features"]["action"]["names"]
    assert names == [f"action.{i}" for i in range(7)]  # what they mean is not known


def test_actions_of_both_robosuites() -> None:
    parts = {"right": {"type": "OSC_POSE", "input_type": "delta"}}
    newer = {"env_kwargs": {"controller_configs": {"type": "BASIC", "body_parts": parts}}}
    for env_args in (made_up.ENV_ARGS, newer):
        assert action_names(env_args, "actions", 7)[0] == "dx"
        assert action_names(env_args, "actions_abs", 7)[0] == "action.0"
    assert action_names({"env_kwargs": {"controller_configs": "osc.json"}}, "actions", 7)[0] != "dx"
    parts["right"]["input_type"] = "absolute"
    assert action_names(newer, "actions", 7)[0] == "action.0"


@pytest.mark.parametrize("env_name", ["Lift", "PickPlaceCan", "NutAssemblySquare"])
def test_the_parts_of_object_are_robosuites(env_name: str) -> None:
    """Stock robosuite says which observables make up `object-state`, and in which order."""
    import robosuite

    env = robosuite.make(
        env_name, robots="Panda", has_renderer=False, has_offscreen_renderer=False,
        use_camera_obs=False,
    )  # fmt: skip
    active = [o for o in env._observables.values() if o.modality == "object" and o.is_active()]
    env.close()
    sizes = [(o.name, int(np.prod(o._data_shape))) for o in active]
    args = {"env_name": env_name, "env_version": robosuite.__version__}
    assert [(name, len(axes)) for name, axes in object_parts(args)] == sizes


def test_the_parts_of_object_depend_on_robosuites_version() -> None:
    """Up to 1.4: `[obj_pos, obj_quat, obj_to_eef_pos, obj_to_eef_quat]`."""
    can = {"env_name": "PickPlaceCan", "env_version": "1.4.1"}
    assert [name for name, _ in object_parts(can)][:2] == ["Can_pos", "Can_quat"]
    assert object_parts({"env_name": "PickPlaceCan"}) == ()
    assert object_parts({"env_name": "ToolHang", "env_version": "1.4.1"}) == ()


def odd(path: Path, name: str) -> None:
    """A file as other projects write them."""
    import h5py

    with h5py.File(path, "r+") as file:
        data = file["data"]
        if name == "nothing said":
            data.attrs["env_args"] = '{"env_name": null, "env_kwargs": null}'
        elif name == "one number an action":
            del data["demo_2/actions"], data["demo_0/actions"]
            data["demo_0"].create_dataset("actions", data=np.zeros(12))
            data["demo_2"].create_dataset("actions", data=np.zeros(7))
        elif name == "a link to nowhere":
            data["demo_7"] = h5py.ExternalLink("elsewhere.hdf5", "/data/demo_7")
        elif name == "an array behind a link":
            del data["demo_0/obs/object"]
            data["demo_0/obs/object"] = h5py.ExternalLink("elsewhere.hdf5", "/x")


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("nothing said", "does not say its control_freq; give --fps"),
        ("one number an action", r"no array of vectors: .*demo_0/actions, found \(12,\)"),
        ("a link to nowhere", "a demonstration that cannot be read: .*data/demo_7"),
        ("an array behind a link", "no array that can be read: .*demo_0/obs/object"),
    ],
)
def test_what_cannot_be_imported_is_one_line(
    name: str, line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = made_up.write(tmp_path / "odd.hdf5", made_up.demos())
    odd(path, name)
    assert main(["import", str(path), "--to", str(tmp_path / "out")]) == 2
    assert re.search(line, capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


def test_an_environment_without_a_name_has_an_instruction(tmp_path: Path) -> None:
    path = made_up.write(tmp_path / "x.hdf5", made_up.demos(), made_up.ENV_ARGS | {"env_name": ""})
    assert main(["import", str(path), "--to", str(tmp_path / "out")]) == 0
    tasks = pq.read_table(tmp_path / "out" / EPISODES)["tasks"].to_pylist()
    assert {words for listed in tasks for words in listed} == {"unknown"}
