"""Actions that were executed give the logged states again; any others do not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.artifacts import file_hash, write_json
from lfr.curation.replay import chosen, find_logs, replay_log
from lfr.data.episode import EpisodeInfo
from lfr.data.log import EpisodeLog, Frame
from lfr.errors import DataError, LfrError
from lfr.sim.simulation import Simulation

STEPS = 8


def record(path: Path, seed: int) -> list[Frame]:
    """Random actions on Panda, as the recorder logs them: the label is not what is executed."""
    simulation, rng = Simulation("panda", "lift"), np.random.default_rng(seed)
    observation, frames = simulation.reset(seed), []
    for _ in range(STEPS):
        action, state = rng.uniform(-1, 1, 7), simulation.state()
        joints = simulation.joint_position()
        steps = simulation.step(action[None])
        frames.append(Frame(observation, joints, 0.5 * action, float(steps.rewards[-1]),
                            bool(steps.successes[-1]), state, action))  # fmt: skip
        observation = steps.observations[-1]
    write(path, frames, simulation.state(), seed)
    return frames


def write(path: Path, frames: list[Frame], last: np.ndarray, seed: int = 0) -> None:
    layout = Simulation("panda", "lift").layout
    info = EpisodeInfo("panda", "lift", seed, "lift the cube", layout.state_names,
                       layout.environment.names)  # fmt: skip
    with EpisodeLog(path, info) as log:
        for frame in frames:
            log.frame(frame)
        log.finish(last)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("replay") / "data/logs/panda-lift"
    for seed in range(2):
        record(folder / f"episode-{seed:06d}.mcap", seed)
    return folder


def test_states_come_back_exactly(logs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for episode, log in find_logs(logs):
        replay = replay_log(log, episode)
        assert (replay.same, replay.difference, replay.frames) == (True, 0.0, STEPS)
    assert cli.main(["replay", str(logs)]) == 0
    assert "2 of 2 episodes come back, 2 exactly" in capsys.readouterr().out
    assert cli.main(["replay", str(logs), "--episode", "1"]) == 0
    assert "1 of 1" in capsys.readouterr().out


def test_a_changed_action_is_noticed_where_it_was(
    logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "changed.mcap"
    frames = record(log, 1)
    executed = frames[5].executed_action
    assert executed is not None
    frames[5] = replace(frames[5], executed_action=executed + 0.01)
    write(log, frames, np.zeros_like(frames[0].simulator_state), 1)
    replay = replay_log(log)
    assert not replay.same
    assert replay.step == 5
    assert replay.difference > 1e-6
    assert cli.main(["replay", str(log)]) == 1
    assert "DIFFERENT after action 5 of 8" in capsys.readouterr().out


def test_the_tolerance_is_of_the_state(tmp_path: Path) -> None:
    log = tmp_path / "nearly.mcap"
    frames = record(log, 0)
    frames[3] = replace(frames[3], simulator_state=frames[3].simulator_state + 1e-7)
    simulation = Simulation("panda", "lift")
    simulation.set_state(frames[0].simulator_state)
    simulation.step(np.array([f.executed_action for f in frames]))
    write(log, frames, simulation.state())
    strict, loose = replay_log(log), replay_log(log, tolerance=1e-6)
    assert (strict.same, strict.step) == (False, 2)
    assert loose.same
    np.testing.assert_allclose(loose.difference, 1e-7, rtol=1e-3)


def test_a_state_of_another_simulation_is_said(tmp_path: Path) -> None:
    log = tmp_path / "other.mcap"
    frames = [replace(f, simulator_state=np.zeros(5)) for f in record(log, 0)]
    write(log, frames, np.zeros(5))
    replay = replay_log(log)
    assert not replay.same
    assert "state has shape (5,)" in str(replay)


def test_a_datasets_logs_are_found_by_their_hashes(logs: Path) -> None:
    dataset = logs.parent.parent / "lerobot/panda-lift"
    files = [log for _, log in find_logs(logs)]
    rows = {
        "episode_index": [0, 1],
        "length": [STEPS] * 2,
        "log_file": [file.name for file in files[::-1]],
        "log_sha256": [file_hash(file) for file in files[::-1]],
    }
    (dataset / "meta/episodes/chunk-000").mkdir(parents=True)
    pq.write_table(pa.table(rows), dataset / "meta/episodes/chunk-000/file-000.parquet")
    write_json(dataset / "meta/info.json", {"codebase_version": "v3.0"})
    assert find_logs(dataset) == [(0, files[1]), (1, files[0])]
    assert cli.main(["replay", str(dataset)]) == 0
    with (files[0]).open("ab") as stream:
        stream.write(b" ")
    with pytest.raises(DataError, match="not the log that the episode was packed from"):
        find_logs(dataset)
    files[0].write_bytes(files[0].read_bytes()[:-1])


def test_what_cannot_be_replayed(logs: Path, tmp_path: Path, by_lerobot: Path) -> None:
    with pytest.raises(DataError, match="no simulator states, and its logs are not there"):
        find_logs(by_lerobot)
    with pytest.raises(DataError, match="no logs"):
        find_logs(tmp_path)
    with pytest.raises(LfrError, match="no episode 9; expected 0 to 1"):
        chosen(find_logs(logs), 9)
