"""Every arm under every controller, from the expert's first motion to the card of its dataset."""

from __future__ import annotations

from pathlib import Path

import pytest

from lfr import cli
from lfr.curation.replay import find_logs, replay_log
from lfr.curation.verify import verify_dataset
from lfr.data.checks import check_dataset
from lfr.data.dataset import pack_dataset
from lfr.data.log_reader import list_logs
from lfr.demos.recorder import RecordParams, record_demonstrations
from lfr.embodiments import embodiment
from lfr.errors import DataError
from lfr.hub.dataset_card import dataset_card
from lfr.hub.dataset_facts import read_facts
from tests.sim.pairs import EMBODIMENTS
from tests.view import rrd

QUICK = "ur5e-joint_position"
NAMES = [
    pytest.param(name, marks=() if name == QUICK else pytest.mark.slow) for name in EMBODIMENTS
]


@pytest.mark.parametrize("name", NAMES)
def test_it_is_recorded_packed_verified_replayed_seen_and_described(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    logs = tmp_path / "data/logs" / f"{name}-stack"
    dataset = tmp_path / "data/lerobot" / f"{name}-stack"
    params = RecordParams(episodes=2, cameras=())
    made = record_demonstrations(name, "stack", params, logs, tmp_path / "work")
    assert made["episodes"] == 2

    pack_dataset(list_logs(logs), dataset)
    check_dataset(dataset, fps=20, robot=name, task="stack")
    assert not verify_dataset(dataset).errors
    with pytest.raises(DataError, match="another robot or controller"):
        check_dataset(dataset, robot=_other_controller(name))

    for episode, log in find_logs(logs):
        assert replay_log(log, episode).same

    body, facts = embodiment(name), read_facts(dataset)
    card = dataset_card(facts)
    action = next(column for column in facts.columns if column.key == "action")
    assert action.names == body.action.names
    assert all(f"{size:g}" in card for size in body.action_scale)

    shown = tmp_path / "episode.rrd"
    assert cli.main(["view", str(dataset), "--save", str(shown)]) == 0
    seen = rrd.read(shown)
    assert any("gripper0" in path for path in seen)
    assert any(path.startswith("/action/") for path in seen)


def _other_controller(name: str) -> str:
    arm, *controller = name.split("-")
    return arm if controller else f"{arm}-joint_position"
