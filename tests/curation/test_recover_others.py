"""MCAP files that other writers made: no checksum over all, schemas lost or never repeated."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from lfr.curation.recover import recover
from lfr.errors import DataError

PER_TOPIC = 60


def write(path: Path, compression: CompressionType = CompressionType.ZSTD, **how: bool) -> Path:
    """Two topics of two schemas, small chunks; the second topic begins half-way."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=400, compression=compression,
                        enable_data_crcs=False, **how)  # fmt: skip
        writer.start()
        schemas = [writer.register_schema(name, "jsonschema", b"{}") for name in ("A", "B")]
        channels = [
            writer.register_channel(topic, "json", schema)
            for topic, schema in zip(("/joints", "/force"), schemas, strict=True)
        ]
        for step in range(PER_TOPIC):
            for channel in channels[: 1 + (step >= PER_TOPIC // 2)]:
                writer.add_message(channel, step * 10**7, b'{"value": %d}' % step, step * 10**7)
        writer.finish()
    return path


def damage(path: Path, number: int) -> None:
    """Change a byte inside a chunk's records; the file's end stays whole."""
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    chunk = summary.chunk_indexes[number]
    content = bytearray(path.read_bytes())
    start = chunk.chunk_start_offset + 9 + 16 + 8 + 4 + 4 + len(chunk.compression) + 8
    content[start + chunk.compressed_size // 2] ^= 0xFF
    path.write_bytes(bytes(content))


def topics(path: Path) -> dict[str, int]:
    found: dict[str, int] = {}
    with path.open("rb") as stream:
        for _, channel, _ in make_reader(stream, validate_crcs=True).iter_messages():
            found[channel.topic] = found.get(channel.topic, 0) + 1
    return found


@pytest.mark.parametrize("compression", list(CompressionType))
def test_a_damaged_chunk_of_a_finished_file(compression: CompressionType, tmp_path: Path) -> None:
    path = write(tmp_path / "bag.mcap", compression)
    whole = topics(path)
    assert recover(path).mended is None
    damage(path, 3)
    recovery = recover(path)
    assert recovery.mended is not None
    assert recovery.damaged == 1
    assert "lost: 1 damaged chunks" in str(recovery)
    left = topics(recovery.mended)
    assert 0 < sum(whole.values()) - sum(left.values()) < 20


def test_what_the_summary_does_not_repeat(tmp_path: Path) -> None:
    """Finished, and unreadable to who trusts the summary alone."""
    path = write(tmp_path / "bag.mcap", repeat_channels=False, repeat_schemas=False)
    recovery = recover(path)
    assert recovery.mended is not None
    assert topics(recovery.mended) == {"/joints": PER_TOPIC, "/force": PER_TOPIC // 2}


def test_schemas_of_a_lost_chunk_come_from_the_summary(tmp_path: Path) -> None:
    path = write(tmp_path / "bag.mcap")
    damage(path, 0)
    recovery = recover(path)
    assert recovery.mended is not None
    left = topics(recovery.mended)
    assert left["/force"] == PER_TOPIC // 2
    assert PER_TOPIC - 20 < left["/joints"] < PER_TOPIC
    assert not recovery.nameless


def test_schemas_that_are_lost_altogether_are_named(tmp_path: Path) -> None:
    path = write(tmp_path / "bag.mcap")
    damage(path, 0)
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content))])
    with pytest.raises(DataError, match=r"no whole message: .*, found \d+ messages.*is lost"):
        recover(path)
    assert not (tmp_path / "bag.recovered.mcap").exists()
