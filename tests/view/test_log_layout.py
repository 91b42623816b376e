"""The committed layout of raw logs: current, and of topics and fields that rerun finds in one."""

import re
import subprocess
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from rerun.experimental import RrdReader

from lfr.embodiments import embodiment
from lfr.view.log_layout import APPLICATION, DEFAULT, FILE, MESSAGE, TIMELINE, log_blueprint, plots
from lfr.view.viewer import executable

from .conftest import Recorded

IDENTITY = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-|\[16\]")  # a UUID, as a path or as bytes


def contents(path: Path) -> list[str]:
    """What a blueprint holds, without the identities that each making draws anew."""
    found = []
    reader = RrdReader(path)
    for chunk in reader.stream(store=reader.blueprints()[0]).to_chunks():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            row = f"{name} {batch.column(name).to_pylist()}"
            if ":" in name and not IDENTITY.search(f"{row} {batch.schema.field(name).type}"):
                found.append(row)
    return sorted(found)


def test_the_committed_file_is_current(tmp_path: Path) -> None:
    fresh = tmp_path / "log.rbl"
    log_blueprint(embodiment(DEFAULT)).save(APPLICATION, str(fresh))
    assert contents(FILE) == contents(fresh)
    assert any("Action: rotation" in row for row in contents(FILE))
    (store,) = RrdReader(FILE).blueprints()
    assert store.application_id == APPLICATION


@pytest.fixture(scope="module")
def raw(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log as plain rerun reads it."""
    out = tmp_path_factory.mktemp("raw") / "episode.rrd"
    command = [str(executable()), "mcap", "convert", "--application-id", APPLICATION]
    subprocess.run([*command, str(recorded.log), "-o", str(out)], check=True, capture_output=True)
    return out


def test_every_plotted_field_is_in_a_log(recorded: Recorded, raw: Path) -> None:
    fields: dict[str, pa.DataType] = {}
    timelines: dict[str, list[str]] = {}
    entities = set()
    for chunk in RrdReader(raw).stream().to_chunks():
        schema = chunk.to_record_batch().schema
        entities.add(chunk.entity_path)
        for name in schema.names:
            if name.endswith(f":{MESSAGE}"):
                fields[f"{chunk.entity_path} {name}"] = schema.field(name).type.value_type
                timelines[chunk.entity_path] = list(chunk.timeline_names)
    for plot in plots(embodiment(recorded.episode.robot)):
        message = fields[f"{plot.topic} {plot.schema}:{MESSAGE}"]
        assert TIMELINE in timelines[plot.topic]
        for selector in plot.fields:
            assert selected(message, selector) == pa.float64(), (plot.name, selector)
    assert {"/tf", "/camera/agentview", "/camera/wrist"} <= entities


@pytest.mark.parametrize("cameras", [(), ("agentview", "wrist", "sideview")])
def test_the_layout_of_logs_with_other_cameras(cameras: tuple[str, ...], tmp_path: Path) -> None:
    out = tmp_path / "log.rbl"
    log_blueprint(embodiment(DEFAULT), cameras).save(APPLICATION, str(out))
    origins = [row for row in contents(out) if row.startswith("ViewBlueprint:space_origin")]
    assert {c for c in ("agentview", "wrist", "sideview") if f"/camera/{c}" in str(origins)} == {
        *cameras
    }


def selected(message: Any, selector: str) -> pa.DataType:
    for part in selector.strip(".").split("."):
        message = message.field(part.removesuffix("[]")).type
        if part.endswith("[]"):
            message = message.value_type
    return message
