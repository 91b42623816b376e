"""Episodes of any number of joints, from the log through every tool: nothing counts to seven."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from lfr.cli import main
from lfr.curation.edit import delete_episodes
from lfr.curation.replay import replay_log
from lfr.curation.verify import verify_dataset
from lfr.data.dataset import pack_dataset
from lfr.data.episode import ACTION, JOINT_POSITION, EpisodeInfo, features
from lfr.data.log import EpisodeLog, Frame
from lfr.data.windows import Windows, read_dataset
from lfr.embodiments import embodiment, is_known
from lfr.errors import DataError
from lfr.hub.dataset_card import dataset_card
from lfr.hub.dataset_facts import read_facts
from lfr.sim.simulation import simulation
from lfr.spaces import Space, gripper_action, joint_motion

from .view import rrd

KNOWN = "ur5e-joint_position" if is_known("ur5e") else "panda-joint_position"
LENGTHS = (6, 9, 7)


@dataclass(frozen=True)
class Recorded:
    """Logs, the dataset packed from them, and the actions in them."""

    logs: list[Path]
    dataset: Path
    actions: list[np.ndarray]


def of_known_arm(folder: Path) -> Recorded:
    """Random joint motions, simulated, and said to have succeeded."""
    running = simulation(KNOWN, "lift")
    logs, actions = [], []
    for seed, length in enumerate(LENGTHS):
        rng = np.random.default_rng(seed)
        done = rng.uniform(-1, 1, (length, running.action_size))
        logs.append(folder / "logs" / f"{KNOWN}-lift" / f"episode-{seed:06d}.mcap")
        observation = running.reset(seed)
        with EpisodeLog(logs[-1], EpisodeInfo.of(running.embodiment, running.task, seed)) as log:
            for t, action in enumerate(done):
                joints, state = running.joint_position(), running.state()
                poses = running.body_poses()
                steps = running.step(action[None])
                log.frame(Frame(observation, joints, action, float(steps.rewards[0]),
                                t == length - 1, state, action, body_poses=poses))  # fmt: skip
                observation = steps.observations[0]
            log.finish(running.state(), running.body_poses())
        actions.append(done.astype(np.float32))
    return _packed(folder, f"{KNOWN}-lift", logs, actions)


def of_unknown_arm(folder: Path, joints: int) -> Recorded:
    """Made-up numbers of an arm that only its names tell of."""
    names = tuple(f"j{number}" for number in range(joints))
    action = Space((joint_motion(names), gripper_action())).names
    seen = ("eef_pos.x", "eef_pos.y", "eef_pos.z", "gripper_aperture")
    schema = features(seen, ("cube_pos.x", "cube_pos.y", "cube_pos.z"), names, action)
    logs, actions = [], []
    for seed, length in enumerate(LENGTHS):
        rng = np.random.default_rng(seed)
        done = rng.uniform(-1, 1, (length, len(action)))
        logs.append(folder / "logs" / "mine-reach" / f"episode-{seed:06d}.mcap")
        with EpisodeLog(logs[-1], EpisodeInfo("mine", "reach", seed, "reach it", schema)) as log:
            for t, one in enumerate(done):
                observation, angles = rng.uniform(-0.5, 0.5, 7), rng.uniform(-1, 1, joints)
                state, reward = rng.normal(size=5), float(rng.uniform())
                log.frame(Frame(observation, angles, one, reward, t == length - 1, state))
            log.finish(rng.normal(size=5))
        actions.append(done.astype(np.float32))
    return _packed(folder, "mine-reach", logs, actions)


def _packed(folder: Path, name: str, logs: list[Path], actions: list[np.ndarray]) -> Recorded:
    dataset = folder / "lerobot" / name
    pack_dataset(logs, dataset, video=False)
    return Recorded(logs, dataset, actions)


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return of_known_arm(tmp_path_factory.mktemp("known"))


@pytest.fixture(scope="module", params=[5, 6, 14])
def unknown(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return of_unknown_arm(tmp_path_factory.mktemp("unknown"), request.param)


def check_dataset_and_parts(recorded: Recorded, folder: Path) -> None:
    """It verifies, is read into windows, and what is cut out of it still does both."""
    report = verify_dataset(recorded.dataset, recorded.logs[0].parent)
    assert report.errors == []
    shorter = folder / "shorter"
    delete_episodes(recorded.dataset, [1], shorter)
    kept = [recorded.actions[0], recorded.actions[2]]
    for dataset, actions in ((recorded.dataset, recorded.actions), (shorter, kept)):
        found = read_dataset(dataset)
        np.testing.assert_array_equal(found.actions, np.concatenate(actions))
        windows = Windows(found, 4, padded=False).all().actions
        assert windows.shape == (sum(len(a) - 3 for a in actions), 4, actions[0].shape[1])


def test_a_known_arm_under_joint_position_control(known: Recorded, tmp_path: Path) -> None:
    check_dataset_and_parts(known, tmp_path)
    for number, log in enumerate(known.logs):
        replay = replay_log(log, number)
        assert (replay.difference, replay.problem) == (0.0, "")


def test_the_card_of_a_known_arm_says_what_a_1_asks_of_each_joint(known: Recorded) -> None:
    body = embodiment(KNOWN)
    text = dataset_card(read_facts(known.dataset))
    assert f"by the arm {body.robot.stock_name}" in text
    (action,) = (each for each in body.action.quantities if each.name == "dq")
    for name, scale in zip(action.names, action.scale, strict=True):
        assert f"| `{name}` | {scale:g} rad |" in text
    assert body.controller.about(body.robot) in text
    assert f"| `{body.robot.joints[0]}` to `{body.robot.joints[-1]}` | rad |" in text


@pytest.mark.parametrize("whole", [True, False])
def test_a_known_arm_is_seen_with_its_joint_motions(
    whole: bool, known: Recorded, tmp_path: Path
) -> None:
    """Its log, and a dataset without logs, of which the poses are computed from observations."""
    body, out = embodiment(KNOWN), tmp_path / "episode.rrd"
    alone = shutil.copytree(known.dataset, tmp_path / "alone" / known.dataset.name)
    path = [str(known.logs[1])] if whole else [str(alone), "--episode", "1"]
    assert main(["view", *path, "--save", str(out)]) == 0
    entities = rrd.read(out)
    motions = rrd.rows(out, "/action/dq", "Scalars:scalars")
    np.testing.assert_array_equal(motions.astype(np.float32), known.actions[1][:, :-1])
    assert entities["/action/dq"]["SeriesLines:names"][1][0] == list(body.robot.joint_names)
    assert rrd.rows(out, "/joints", "Scalars:scalars").shape[1] == len(body.robot.joints)
    words = [state[0] for state in entities["/state/gripper"]["StateChange:state"][1]]
    assert words == np.where(known.actions[1][:, -1] > 0, "close", "open").tolist()
    moving = [f"/world/{arm}" for arm in body.robot.distal_bodies] + ["/world/cube_main"]
    posed = [entities[path]["Transform3D:translation"][1] for path in moving if path in entities]
    assert len(posed) > 2
    assert {len(places) for places in posed} == {LENGTHS[1] + 1 if whole else LENGTHS[1]}


def test_two_controllers_stand_side_by_side(known: Recorded, tmp_path: Path) -> None:
    pair, log = tmp_path / "pair.rrd", str(known.logs[0])
    assert main(["view", str(known.dataset), "--side-by-side", log, "--save", str(pair)]) == 0
    entities = rrd.read(pair)
    for side in ("/left", "/right"):
        assert f"{side}/action/dq" in entities


def test_logs_of_two_controllers_make_no_dataset(known: Recorded, tmp_path: Path) -> None:
    running = simulation(embodiment(KNOWN).robot.name, "lift")
    other = tmp_path / "other.mcap"
    with EpisodeLog(other, EpisodeInfo.of(running.embodiment, running.task, 9)) as log:
        still = np.zeros(running.action_size)
        log.frame(Frame(running.reset(9), running.joint_position(), still, 0.0, True,
                        running.state()))  # fmt: skip
        log.finish(running.state())
    with pytest.raises(DataError, match=f"column robot.*expected {KNOWN}"):
        pack_dataset([known.logs[0], other], tmp_path / "mixed", video=False)
    assert not (tmp_path / "mixed").exists()


def test_an_unknown_arm_of_any_number_of_joints(unknown: Recorded, tmp_path: Path) -> None:
    check_dataset_and_parts(unknown, tmp_path)
    count = unknown.actions[0].shape[1]
    columns = {column.key: column for column in read_facts(unknown.dataset).columns}
    assert columns[ACTION].shape == (count,)
    assert columns[JOINT_POSITION].shape == (count - 1,)
    text = dataset_card(read_facts(unknown.dataset))
    assert "`dq.j0`, `dq.j1`" in text
    assert " rad |" not in text  # what a 1 asks for, no name says
    out = tmp_path / "episode.rrd"
    assert main(["view", str(unknown.dataset), "--episode", "2", "--save", str(out)]) == 0
    entities = rrd.read(out)
    shown = [np.array(entities[path]["Scalars:scalars"][1])[:, :] for path in sorted(entities)
             if path.startswith("/action/")]  # fmt: skip
    assert sum(values.shape[1] for values in shown) == count
    assert rrd.rows(out, "/joints", "Scalars:scalars").shape == (LENGTHS[2], count - 1)
