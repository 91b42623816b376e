"""Demonstrations of Panda's Lift, recorded for real: what is kept, counted, logged and replayed."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lfr.data.dataset import pack_dataset
from lfr.data.episode import IMAGES
from lfr.data.log_reader import body_poses, list_logs, read_log
from lfr.demos import recorder
from lfr.demos.attempt import Moment
from lfr.demos.recorder import CameraParams, RecordParams, record_demonstrations
from lfr.errors import LfrError, ParameterError
from lfr.records import from_mapping
from lfr.sim.camera import camera_available
from lfr.sim.simulation import Simulation

PARAMS = RecordParams(episodes=2, cameras=())


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs run here, where simulations are already there and patches hold."""
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: 1)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("recorded")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.cpu_count", lambda: 1)
        work = folder / "work"
        work.mkdir()
        return folder, record_demonstrations("panda", "lift", PARAMS, folder / "logs", work)


def failing(monkeypatch: pytest.MonkeyPatch, seeds: set[int]) -> None:
    """Have the attempts at these seeds end before anything is achieved."""
    attempt = recorder.attempt

    def cut(simulation: Any, params: Any, seed: int) -> Iterator[Moment]:
        for step, moment in enumerate(attempt(simulation, params, seed)):
            if seed in seeds and step == 5:
                return
            yield moment

    monkeypatch.setattr(recorder, "attempt", cut)


def test_successes_are_logged_and_counted(recorded: tuple[Path, dict[str, Any]]) -> None:
    folder, metrics = recorded
    logs = list_logs(folder / "logs")
    assert [log.name for log in logs] == ["episode-000000.mcap", "episode-000001.mcap"]
    episodes = [read_log(log) for log in logs]
    assert [episode.seed for episode in episodes] == sorted(episode.seed for episode in episodes)
    assert all(episode.success for episode in episodes)
    assert metrics["frames"] == sum(map(len, episodes))
    assert metrics["attempts"] == metrics["failures"] + 2
    assert metrics["cameras"] == []
    lingering = [int(episode.features["next.success"].sum()) for episode in episodes]
    assert min(lingering) >= PARAMS.attempt.linger  # so that windows of a skill are whole


def test_a_log_shows_what_happened(recorded: tuple[Path, dict[str, Any]]) -> None:
    """Its executed actions, from its first state, give its states and poses again."""
    log = list_logs(recorded[0] / "logs")[0]
    episode, poses = read_log(log), body_poses(log)
    assert episode.executed_action is not None
    simulation = Simulation("panda", "lift")
    simulation.set_state(episode.simulator_state[0])
    for t, action in enumerate(episode.executed_action):
        expected = {n: np.concatenate(pose) for n, pose in simulation.body_poses().items()}
        for name in ("gripper0_right_eef", "cube_main"):
            np.testing.assert_allclose(poses[name][t], expected[name], atol=1e-9)
        np.testing.assert_allclose(
            episode.features["observation.joint_position"][t], simulation.joint_position(),
            atol=1e-6,
        )  # fmt: skip
        simulation.step(action[None])
        np.testing.assert_allclose(simulation.state(), episode.simulator_state[t + 1], atol=1e-12)
    clean = episode.features["action"][:, :3]
    assert np.abs(clean - episode.executed_action[:, :3]).max() > 0.01  # the label is clean


def test_the_same_seed_is_the_same_file(
    recorded: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    logs = list_logs(recorded[0] / "logs")
    (tmp_path / "work").mkdir()
    again = tmp_path / "again"
    record_demonstrations("panda", "lift", PARAMS, again, tmp_path / "work")
    for log in logs:
        first, second = read_log(log), read_log(again / log.name)
        assert first.simulator_state.tobytes() == second.simulator_state.tobytes()
        assert first.features["action"].tobytes() == second.features["action"].tobytes()


CAMERAS = (
    CameraParams("agentview", 64, 48),
    CameraParams("wrist", 32, 64),
    CameraParams("sideview", 48, 48),
)
needs_opengl = pytest.mark.skipif(not camera_available(), reason="no OpenGL (libegl1)")


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """One attempt's log with the first camera alone, and with all three."""
    logs = []
    for cameras in (CAMERAS[:1], CAMERAS):
        folder = tmp_path_factory.mktemp("seen")
        params = RecordParams(episodes=1, cameras=cameras)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("os.cpu_count", lambda: 1)
            metrics = record_demonstrations("panda", "lift", params, folder / "logs", folder)
        assert metrics["cameras"] == [camera.name for camera in cameras]
        logs += list_logs(folder / "logs")
    first, second = logs
    return first, second


@needs_opengl
def test_pictures_are_logged_with_their_cameras(seen: tuple[Path, Path]) -> None:
    from PIL import Image

    episode, poses = read_log(seen[1]), body_poses(seen[1])
    assert list(episode.images) == list(episode.cameras) == [camera.name for camera in CAMERAS]
    for camera in CAMERAS:
        assert len(episode.images[camera.name]) == len(episode)
        size = Image.open(io.BytesIO(episode.images[camera.name][0])).size
        model = episode.cameras[camera.name]
        assert size == (camera.width, camera.height) == (model.width, model.height)
    assert poses["agentview"].shape == poses["sideview"].shape == (1, 7)
    assert poses["wrist"].shape == (len(episode) + 1, 7)
    apart = np.linalg.norm(poses["wrist"][:, :3] - poses["robot0_right_hand"][:, :3], axis=1)
    np.testing.assert_allclose(apart, 0.05, atol=1e-9)
    assert np.ptp(poses["wrist"][:, :3], axis=0).max() > 0.05


@needs_opengl
def test_a_cameras_pictures_do_not_depend_on_the_others(seen: tuple[Path, Path]) -> None:
    alone, together = map(read_log, seen)
    assert list(alone.images) == ["agentview"]
    assert alone.images["agentview"] == together.images["agentview"]
    assert alone.simulator_state.tobytes() == together.simulator_state.tobytes()


@needs_opengl
def test_each_camera_is_a_feature_of_the_dataset(seen: tuple[Path, Path], tmp_path: Path) -> None:
    from lerobot.datasets import LeRobotDataset

    from lfr.curation.verify import verify_dataset

    out = tmp_path / "panda-lift"
    counts = pack_dataset([seen[1]], out)
    assert counts["cameras"] == ["agentview", "wrist", "sideview"]
    row = LeRobotDataset("lfr/panda-lift", root=out, video_backend="pyav")[3]
    shapes = {key: tuple(value.shape) for key, value in row.items() if key.startswith(IMAGES)}
    assert shapes == {f"{IMAGES}{c.name}": (3, c.height, c.width) for c in CAMERAS}
    report = verify_dataset(out, logs=seen[1].parent, pictures=1)
    assert not report.errors


@pytest.mark.parametrize(
    ("cameras", "message"),
    [
        ([{"name": "agentview"}, {"name": "agentview", "width": 64}], "agentview more than once"),
        ([{"name": "hand"}], r"record.cameras\[0\]: unknown camera 'hand'; valid: .*wrist"),
        ([{"name": "wrist", "width": 65}], r"record.cameras\[0\]: width .* found 65"),
        (["wrist"], r"record.cameras\[0\]: found 'wrist', expected a mapping"),
        ("wrist", "record.cameras: found 'wrist', expected a list"),
    ],
)
def test_cameras_that_there_are_not_are_refused_with_their_place(
    cameras: Any, message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        from_mapping(RecordParams, {"cameras": cameras}, "params.yaml: record")


def test_failures_are_counted_and_not_kept(
    recorded: tuple[Path, dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, {0})
    metrics = record_demonstrations("panda", "lift", PARAMS, tmp_path / "logs", tmp_path)
    seeds = [read_log(log).seed for log in list_logs(tmp_path / "logs")]
    assert 0 not in seeds
    assert len(seeds) == 2
    assert 0 in metrics["failed_seeds"]
    assert metrics["failures"] == len(metrics["failed_seeds"]) >= 1
    assert not recorder.log_path(tmp_path, 0).exists()
    assert not list(tmp_path.rglob("*.partial"))


def test_finished_attempts_are_not_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, {0})  # the third attempt is stopped by hand
    made: list[int] = []
    attempt = recorder.attempt

    def counted(simulation: Any, params: Any, seed: int) -> Iterator[Moment]:
        made.append(seed)
        if len(made) == 3:
            raise KeyboardInterrupt
        yield from attempt(simulation, params, seed)

    monkeypatch.setattr(recorder, "attempt", counted)
    with pytest.raises(KeyboardInterrupt):
        record_demonstrations("panda", "lift", PARAMS, tmp_path / "logs", tmp_path)
    assert not (tmp_path / "logs").exists()
    record_demonstrations("panda", "lift", PARAMS, tmp_path / "logs", tmp_path)
    assert made == [0, 1, 2, 2, *range(3, max(made) + 1)]
    assert len(list_logs(tmp_path / "logs")) == 2


def test_an_expert_that_never_succeeds_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, set(range(100)))
    params = RecordParams(episodes=1, most_attempts=3.0, cameras=())
    with pytest.raises(LfrError, match="succeeded in 0 of 3 attempts at lift on panda"):
        record_demonstrations("panda", "lift", params, tmp_path / "logs", tmp_path)
    assert not (tmp_path / "logs").exists()


def test_without_opengl_states_alone_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("lfr.sim.camera.camera_available", lambda: False)
    metrics = record_demonstrations(
        "panda", "lift", RecordParams(episodes=1), tmp_path / "logs", tmp_path
    )
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    assert "libegl1" in printed
    assert metrics["cameras"] == []
    assert not read_log(list_logs(tmp_path / "logs")[0]).images
