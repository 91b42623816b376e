"""LeRobotDataset is the oracle: it opens what we pack, and writes the same files from the logs."""

import hashlib
import io
import json
import multiprocessing
import os
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image

from lfr.artifacts import read_json
from lfr.data import dataset as packing
from lfr.data import frames as frame_files
from lfr.data.dataset import pack_dataset
from lfr.data.episode import Episode
from lfr.data.log import EpisodeLog
from lfr.data.log_reader import read_log
from lfr.errors import DataError

from . import made_up
from .conftest import IMAGE_SIZE, LENGTHS

CAMERA = "observation.images.agentview"
DATA = "data/chunk-000/file-000.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
OURS = {"seed", "success", "robot", "task_name", "log_file", "log_sha256"}


@pytest.fixture(scope="module")
def reference(logs: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same episodes, recorded frame by frame with LeRobot's own writer."""
    from lerobot.datasets import LeRobotDataset

    episodes = [read_log(log) for log in logs]
    features: dict[str, Any] = {
        key: {"dtype": f.dtype, "shape": f.shape, "names": list(f.names or ())}
        for key, f in episodes[0].schema.items()
    }
    shape = (IMAGE_SIZE, IMAGE_SIZE, 3)
    names = ["height", "width", "channels"]
    features[CAMERA] = {"dtype": "video", "shape": shape, "names": names}
    root = tmp_path_factory.mktemp("reference") / "panda-lift"
    recorded = LeRobotDataset.create("lfr/panda-lift", 20, features, root=root, robot_type="panda")
    for episode in episodes:
        for t in range(len(episode)):
            frame: dict[str, Any] = {
                key: np.atleast_1d(values[t]) for key, values in episode.features.items()
            }
            frame[CAMERA] = _pixels(episode.images["agentview"][t])
            recorded.add_frame({**frame, "task": episode.metadata["instruction"]})
        recorded.save_episode()
    recorded.finalize()
    return root


def _pixels(jpeg: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(jpeg)))


def test_lerobot_opens_it_and_every_row_is_the_logs(packed: Path, logs: list[Path]) -> None:
    from lerobot.datasets import LeRobotDataset

    dataset = LeRobotDataset("lfr/panda-lift", root=packed, video_backend="pyav")
    assert (dataset.num_episodes, dataset.num_frames, dataset.fps) == (4, sum(LENGTHS), 20)
    at = 0
    for index, log in enumerate(logs):
        episode = read_log(log)
        for t in (0, len(episode) // 2, len(episode) - 1):
            row = dataset[at + t]
            for key, values in episode.features.items():
                np.testing.assert_array_equal(np.asarray(row[key]), values[t], err_msg=key)
            assert row["task"] == "Lift the cube."
            assert row["episode_index"] == index
            assert row["frame_index"] == t
            # the frame is this one, not its neighbour, which is 10 levels of red away
            seen = row[CAMERA].permute(1, 2, 0).numpy() * 255
            expected = _pixels(episode.images["agentview"][t])
            assert abs(seen[..., 0].mean() - expected[..., 0].mean()) < 4
        at += len(episode)


def test_the_rows_and_their_schema_are_what_lerobot_writes(packed: Path, reference: Path) -> None:
    ours, theirs = pq.read_table(packed / DATA), pq.read_table(reference / DATA)
    assert ours.equals(theirs)  # names, types and values
    # what `datasets` reads the types from; LeRobot's own has a random fingerprint beside it
    info = [json.loads(table.schema.metadata[b"huggingface"])["info"] for table in (ours, theirs)]
    assert info[0] == info[1]
    for path in (packed, reference):
        assert pq.read_metadata(path / DATA).num_row_groups == len(LENGTHS)
    assert pq.read_table(packed / "meta/tasks.parquet").equals(
        pq.read_table(reference / "meta/tasks.parquet"), check_metadata=True
    )


def test_info_is_what_lerobot_writes(packed: Path, reference: Path) -> None:
    assert read_json(packed / "meta/info.json") == read_json(reference / "meta/info.json")


def test_the_episodes_are_what_lerobot_writes_and_ours_side_by_side(
    packed: Path, reference: Path, logs: list[Path]
) -> None:
    ours, theirs = pq.read_table(packed / EPISODES), pq.read_table(reference / EPISODES)
    assert set(ours.column_names) == set(theirs.column_names) | OURS
    for name in theirs.column_names:
        assert ours.schema.field(name).type == theirs.schema.field(name).type, name
        if not name.startswith("stats/"):
            assert ours[name].to_pylist() == theirs[name].to_pylist(), name
    assert ours["seed"].to_pylist() == [0, 1, 2, 3]
    assert ours["success"].to_pylist() == [True] * 4
    assert set(ours["robot"].to_pylist()) == {"panda"}
    assert set(ours["task_name"].to_pylist()) == {"lift"}
    assert ours["log_file"].to_pylist() == [log.name for log in logs]
    hashes = [hashlib.sha256(log.read_bytes()).hexdigest() for log in logs]
    assert ours["log_sha256"].to_pylist() == hashes


def test_lerobot_filters_by_our_columns(packed: Path) -> None:
    from lerobot.datasets import LeRobotDatasetMetadata

    meta = LeRobotDatasetMetadata("lfr/panda-lift", root=packed)
    assert meta.filter_episodes(lambda episode: episode["seed"] >= 2 and episode["success"]) == [
        2,
        3,
    ]


@pytest.mark.parametrize("level", ["dataset", "episode"])
def test_statistics_agree_with_lerobots_but_for_its_quantiles(
    packed: Path, reference: Path, level: str
) -> None:
    ours, theirs = _stats(packed, level), _stats(reference, level)
    assert set(ours) == set(theirs)
    for (key, name), expected in theirs.items():
        assert ours[key, name].shape == expected.shape, (key, name)
        if name in ("min", "max", "mean", "std"):
            # LeRobot computes in float32
            np.testing.assert_allclose(
                ours[key, name], expected, rtol=1e-4, atol=2e-3 if key == CAMERA else 2e-5
            )
        elif name == "count":
            assert ours[key, name] == expected


def _stats(root: Path, level: str) -> dict[tuple[str, str], np.ndarray]:
    if level == "dataset":
        stats = read_json(root / "meta/stats.json")
        return {(key, name): np.array(v) for key, s in stats.items() for name, v in s.items()}
    row = pq.read_table(root / EPISODES).to_pylist()[2]
    parts = {tuple(name.split("/")[1:]): v for name, v in row.items() if name.startswith("stats/")}
    return {(key, name): np.array(value) for (key, name), value in parts.items()}


def test_quantiles_are_those_of_all_rows(packed: Path, logs: list[Path]) -> None:
    """By counting: a q-quantile has a fraction q of the values below it."""
    stats = read_json(packed / "meta/stats.json")
    rows = np.concatenate([read_log(log).features["action"] for log in logs])
    for name, q in {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}.items():
        below = (rows < stats["action"][name]).mean(axis=0)
        assert np.all(np.abs(below - q) <= 1 / len(rows))
    pixels = np.concatenate([_pixels(f)[None] for log in logs for f in _images(log)]) / 255
    for name, q in {"q01": 0.01, "q50": 0.5, "q99": 0.99}.items():
        expected = np.quantile(pixels.reshape(-1, 3), q, axis=0)
        np.testing.assert_allclose(np.ravel(stats[CAMERA][name]), expected, atol=1e-12)


def _images(log: Path) -> list[bytes]:
    return list(read_log(log).images["agentview"])


def test_every_dimension_is_named(packed: Path) -> None:
    features = read_json(packed / "meta/info.json")["features"]
    for episode_feature in read_log_schema(packed, features):
        assert len(episode_feature["names"]) == episode_feature["shape"][0]
    assert features["observation.environment_state"]["names"] == list(made_up.ENVIRONMENT_NAMES)


def read_log_schema(packed: Path, features: dict[str, Any]) -> list[dict[str, Any]]:
    return [f for key, f in features.items() if key.startswith(("observation.", "action", "next."))
            and f["dtype"] != "video"]  # fmt: skip


def test_packing_again_gives_the_same_bytes(packed: Path, logs: list[Path], tmp_path: Path) -> None:
    pack_dataset(logs, tmp_path / "panda-lift", video=True)
    files = [p.relative_to(packed) for p in sorted(packed.rglob("*")) if p.is_file()]
    assert len(files) == 6
    for file in files:
        assert (packed / file).read_bytes() == (tmp_path / "panda-lift" / file).read_bytes(), file


def test_without_video_there_are_no_images(logs: list[Path], tmp_path: Path) -> None:
    counts = pack_dataset(logs[:2], tmp_path / "panda-lift", video=False)
    assert counts == {"episodes": 2, "frames": 21, "successes": 2, "cameras": []}
    info = read_json(tmp_path / "panda-lift/meta/info.json")
    assert CAMERA not in info["features"]
    assert info["video_path"] is None
    assert not (tmp_path / "panda-lift/videos").exists()


def test_a_large_dataset_is_split_into_files(
    logs: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lfr.data import video, windows

    monkeypatch.setattr(frame_files, "MAX_BYTES", 4000)
    monkeypatch.setattr(video, "MAX_BYTES", 0)  # what the encoder still holds has no size
    pack_dataset(logs, tmp_path / "split", video=True)  # it compares every row with the logs
    assert len(list((tmp_path / "split/data").rglob("*.parquet"))) > 1
    assert len(list((tmp_path / "split/videos").rglob("*.mp4"))) > 1
    assert windows.read_dataset(tmp_path / "split").lengths.tolist() == list(LENGTHS)


def _log(path: Path, **changes: Any) -> Path:
    """A log of two frames whose last one, or whose info, differs."""
    info = {"robot": "panda", "task": "lift"} | {
        key: changes.pop(key) for key in ("robot", "task") if key in changes
    }
    frames = made_up.frames(seed=9, length=2, image_size=IMAGE_SIZE)
    with EpisodeLog(path, made_up.info(seed=9, **info)) as log:
        log.frame(frames[0])
        log.frame(type(frames[1])(**{**vars(frames[1]), **changes}))
        log.finish(np.zeros(30))
    return path


BAD = {
    "another robot": ({"robot": "sawyer"}, r"column robot, found sawyer, expected panda"),
    "another task": ({"task": "stack"}, r"column task, found stack, expected lift"),
    "not finite": ({"reward": np.nan}, r"episode 1, column next.reward, found nan"),
    "infinite": ({"action": np.full(7, np.inf)}, r"episode 1, column action, found inf"),
    "no camera": ({"images": {}}, r"/camera/agentview, found 1 messages, expected 2"),
    "image size": ({"images": {"agentview": np.zeros((32, 64, 3), np.uint8)}}, "cannot be encoded"),
}


@pytest.mark.parametrize(("changes", "message"), BAD.values(), ids=BAD)
def test_a_bad_log_is_named_and_nothing_is_overwritten(
    logs: list[Path], tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    out = tmp_path / "panda-lift"
    out.mkdir()
    (out / "before").touch()
    bad = _log(tmp_path / "bad.mcap", **changes)
    with pytest.raises(DataError, match=message) as caught:
        pack_dataset([logs[0], bad], out, video=True)
    assert "bad.mcap" in str(caught.value)
    assert [p.name for p in out.iterdir()] == ["before"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.mcap", "panda-lift"]


def test_what_differs_from_the_logs_is_not_given_the_name(
    logs: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As if the disk had changed an action between writing and reading."""
    write = frame_files._arrow
    monkeypatch.setattr(
        frame_files,
        "_arrow",
        lambda values, type: write(values + 1 if values.shape[1:] == (3,) else values, type),
    )
    with pytest.raises(DataError, match=r"differs from its source.*environment_state"):
        pack_dataset(logs[:1], tmp_path / "out", video=False)
    assert list(tmp_path.iterdir()) == []


def _pack_and_die(logs: list[Path], out: Path) -> None:
    """Killed at the third log, with two episodes written."""
    seen: list[Path] = []

    def read(log: Path) -> Episode:
        seen.append(log)
        if len(seen) == 3:
            os.kill(os.getpid(), signal.SIGKILL)
        return read_log(log)

    packing.read_log = read
    pack_dataset(logs, out, video=False)


@pytest.mark.filterwarnings("ignore:.*use of fork:DeprecationWarning")
@pytest.mark.parametrize("before", [False, True])
def test_kill_9_while_packing_leaves_the_final_name_as_it_was(
    packed: Path, logs: list[Path], tmp_path: Path, before: bool
) -> None:
    out = tmp_path / "panda-lift"
    if before:
        shutil.copytree(packed, out)
    # fork: the child has LeRobot already, whose import takes 4 to 17 s
    child = multiprocessing.get_context("fork").Process(target=_pack_and_die, args=(logs, out))
    child.start()
    child.join(timeout=60)
    assert child.exitcode == -signal.SIGKILL
    assert out.exists() == before
    if before:
        assert json.loads((out / "meta/info.json").read_text())["total_episodes"] == 4
    pack_dataset(logs[:1], out, video=False)  # and the next attempt is not in its way
    assert [p.name for p in tmp_path.iterdir()] == ["panda-lift"]
    assert read_json(out / "meta/info.json")["total_episodes"] == 1


def test_pictures_too_small_for_the_encoder_are_refused(tmp_path: Path) -> None:
    """It would end the process with SIGFPE."""
    logs = made_up.write_all(tmp_path / "logs", [2], image_size=16)
    with pytest.raises(DataError, match=r"16 x 16 pixels; AV1 needs 32 x 32.*without video"):
        pack_dataset(logs, tmp_path / "panda-lift")
    assert not (tmp_path / "panda-lift").exists()
    assert pack_dataset(logs, tmp_path / "panda-lift", video=False)["frames"] == 2
