"""What a cut-off log still holds comes back, bit for bit, and what it does not is said."""

import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from lfr import cli
from lfr.curation.recover import recover
from lfr.curation.salvage import salvage
from lfr.data.episode import Episode
from lfr.data.log_reader import read_log
from lfr.errors import DataError

from . import made_up

FRAMES = 70


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "e.mcap"
    made_up.write(path, seed=3, length=FRAMES, image_size=16)
    return path


def is_beginning(found: Episode, of: Episode) -> None:
    """Every value of the first frames is there, and the state after the last of them."""
    count = len(found)
    for key, values in found.features.items():
        if key != "next.done":  # at the end of what is left
            np.testing.assert_array_equal(values, of.features[key][:count], err_msg=key)
    np.testing.assert_array_equal(found.simulator_state, of.simulator_state[: count + 1])
    np.testing.assert_array_equal(found.executed_action, of.executed_action[:count])
    assert found.images["agentview"] == of.images["agentview"][:count]
    assert (found.robot, found.task, found.seed) == (of.robot, of.task, of.seed)
    assert found.success == bool(of.features["next.success"][:count].any())


@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(kept=st.floats(0, 1, exclude_max=True))
def test_cut_anywhere(whole: Path, tmp_path: Path, kept: float) -> None:
    content = whole.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: int(kept * len(content))])
    mended = tmp_path / "cut.recovered.mcap"
    mended.unlink(missing_ok=True)
    recovery = None
    with suppress(DataError):
        recovery = recover(cut)
    if recovery is None:  # before the first flush, 20 frames in
        assert kept < 0.35
        assert not mended.exists()
        return
    assert recovery.mended == mended
    found, original = read_log(mended), read_log(whole)
    is_beginning(found, original)
    assert recovery.frames == len(found)
    assert len(found) >= kept * FRAMES - 25  # a chunk of 20 frames, and one for its end
    assert recovery.outcome_missing or len(found) == FRAMES
    assert cut.read_bytes() == content[: int(kept * len(content))]


def test_killed_while_recording(tmp_path: Path) -> None:
    log = tmp_path / "e.mcap"
    code = (
        "import os\nfrom pathlib import Path\nfrom lfr.data.log import EpisodeLog\n"
        "from tests.curation import made_up\nfrom tests.data.made_up import info\n"
        f"log = EpisodeLog(Path({str(log)!r}), info(7))\n"
        "for frame in made_up.frames(seed=7, length=50): log.frame(frame)\n"
        "os.kill(os.getpid(), 9)"
    )
    root = str(Path(__file__).parents[2])
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": root})
    assert done.returncode == -signal.SIGKILL
    recovery = recover(tmp_path / "e.mcap.partial")
    assert recovery.mended == tmp_path / "e.recovered.mcap"
    assert recovery.frames == 39  # two chunks of 20, of which the last frame gives the end's state
    assert recovery.outcome_missing
    assert not read_log(recovery.mended).success
    made_up.write(log, seed=7, length=50)
    episode, mended = read_log(log), read_log(recovery.mended)
    np.testing.assert_array_equal(mended.simulator_state, episode.simulator_state[:40])


def test_a_damaged_chunk_ends_it(whole: Path, tmp_path: Path) -> None:
    """A gap in the middle: what comes after it does not follow, and is dropped."""
    content = bytearray(whole.read_bytes())
    content[len(content) // 2] ^= 0xFF
    (tmp_path / "e.mcap").write_bytes(content)
    recovery = recover(tmp_path / "e.mcap")
    assert recovery.damaged == 1
    assert recovery.dropped > 0
    assert recovery.expected_frames == FRAMES
    assert recovery.frames is not None
    assert 0 < recovery.frames < FRAMES
    assert recovery.mended is not None
    is_beginning(read_log(recovery.mended), read_log(whole))
    assert re.search(rf"lost: {FRAMES - recovery.frames} frames of {FRAMES}", str(recovery))


def test_changed_metadata_is_minded(whole: Path, tmp_path: Path) -> None:
    """It has no checksum of its own: only the file's differs."""
    content = whole.read_bytes()
    (tmp_path / "e.mcap").write_bytes(content.replace(b"Lift the cube.", b"Lift the tube.", 1))
    recovery = recover(tmp_path / "e.mcap")
    assert recovery.suspect
    assert "metadata may have changed" in str(recovery)


def test_other_readers_open_it(whole: Path, tmp_path: Path) -> None:
    from rerun.experimental import McapReader

    content = whole.read_bytes()
    (tmp_path / "e.mcap").write_bytes(content[: 2 * len(content) // 3])
    mended = recover(tmp_path / "e.mcap").mended
    assert mended is not None
    frames = len(read_log(mended))
    entities = {str(chunk.entity_path) for chunk in McapReader(str(mended)).stream().to_chunks()}
    assert {"/action", "/observation", "/tf"} <= entities
    with mended.open("rb") as stream:  # as Foxglove reads: from the summary
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    topics = {c.topic: summary.statistics.channel_message_counts[i]
              for i, c in summary.channels.items()}  # fmt: skip
    assert topics["/action"] == frames
    assert topics["/simulator_state"] == frames + 1


def test_a_foreign_file_keeps_all_that_is_whole(tmp_path: Path) -> None:
    with (tmp_path / "their.mcap").open("wb") as stream:
        writer = Writer(stream, chunk_size=500)
        writer.start("theirs")
        schema = writer.register_schema("Text", "jsonschema", b"{}")
        channel = writer.register_channel("/text", "json", schema)
        writer.add_metadata("outcome", {"frames": "many"})  # whose name is ours by chance
        for t in range(100):
            writer.add_message(channel, t * 10**9, b'"%d"' % t, t)
        writer.finish()
    content = (tmp_path / "their.mcap").read_bytes()
    (tmp_path / "their.mcap").write_bytes(content[: len(content) // 3])
    saved = len(salvage(tmp_path / "their.mcap").messages)
    recovery = recover(tmp_path / "their.mcap")
    assert 0 < saved == recovery.messages < 100
    assert recovery.frames is None
    assert recovery.mended is not None
    with recovery.mended.open("rb") as stream:
        found = [m.data for _, _, m in make_reader(stream).iter_messages()]
    assert found == [b'"%d"' % t for t in range(saved)]


def test_whole_or_hopeless(whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "e.mcap"
    copy.write_bytes(whole.read_bytes())
    assert cli.main(["recover", str(copy)]) == 0
    assert "whole, nothing to mend" in capsys.readouterr().out
    assert [p.name for p in tmp_path.iterdir()] == ["e.mcap"]
    for content, message in ((b"text", "not an MCAP"), (whole.read_bytes()[:50], "nothing to")):
        copy.write_bytes(content)
        assert cli.main(["recover", str(copy)]) == 2
        assert message in capsys.readouterr().err
    assert cli.main(["recover", str(tmp_path / "absent.mcap")]) == 2
    assert [p.name for p in tmp_path.iterdir()] == ["e.mcap"]


def test_nothing_is_overwritten(whole: Path, tmp_path: Path) -> None:
    (tmp_path / "e.mcap").write_bytes(whole.read_bytes()[:-100])
    mended = recover(tmp_path / "e.mcap").mended
    assert mended is not None
    before = mended.read_bytes()
    with pytest.raises(DataError, match="recovered before"):
        recover(tmp_path / "e.mcap")
    assert mended.read_bytes() == before
