"""An MCAP file written message by message: whole under its name, or not there at all."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from foxglove import Channel, Context, Schema, open_mcap
from foxglove.mcap import MCAPCompression, MCAPWriteOptions

from lfr.data.mcap_file import message_counts, settle
from lfr.errors import DataError


class McapWriter:
    """Writer of one MCAP file, which is `<path>.partial` until `finish` syncs and renames it.

    Attributes:
        path: the file's final name.
        partial: its name until it is finished.
        counts: messages logged so far, by topic.
        finished: whether the file has its name, or was given up.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self.partial = self.path.with_name(self.path.name + ".partial")
        self.counts: Counter[str] = Counter()
        self.finished = False
        self.partial.parent.mkdir(parents=True, exist_ok=True)
        self._context = Context()
        self._file = open_mcap(
            self.partial,
            allow_overwrite=True,  # a .partial that a killed process left
            context=self._context,
            writer_options=MCAPWriteOptions(
                compression=MCAPCompression.Zstd, compression_threads=0, profile=""
            ),
        )
        self._channels: dict[str, Channel] = {}

    def log(self, topic: str, message: Any, now: int, schema: Schema | None = None) -> None:
        """Log a Foxglove message, or the bytes of one of `schema`, at the time `now` (ns)."""
        if topic not in self._channels:
            self._channels[topic] = Channel(
                topic,
                schema=schema or type(message).get_schema(),
                message_encoding="protobuf",
                context=self._context,
            )
        data = message if isinstance(message, bytes) else message.encode()
        self._channels[topic].log(data, log_time=now)
        self.counts[topic] += 1

    def metadata(self, **records: Mapping[str, Any]) -> None:
        """Write metadata records by name."""
        for name, record in records.items():
            self._file.write_metadata(name, _texts(record))

    def flush(self) -> None:
        """Hand what was logged to the disk. Raises DataError when it is full."""
        try:
            self._file.flush()
        except RuntimeError as error:  # the SDK's word for an error of the disk
            raise DataError("the log was not written, is the disk full?", file=self.path) from error

    def finish(self, **records: Mapping[str, Any]) -> None:
        """Write the last metadata records, close the file, count what it holds, and name it.

        Raises:
            DataError: not everything that was logged reached the file, as on a full disk; nothing
                of it stays.
        """
        try:
            self.metadata(**records)
            self._file.close()
            settle(self.partial)
            found = message_counts(self.partial)
        except (OSError, RuntimeError, DataError) as error:
            self.abandon()
            raise DataError("the log was not written, is the disk full?", file=self.path) from error
        if found != dict(self.counts):
            self.abandon()
            raise DataError(
                "the log was not written whole, is the disk full?",
                file=self.path,
                found=f"{sum(found.values())} messages",
                expected=sum(self.counts.values()),
            )
        os.replace(self.partial, self.path)
        _sync_folder(self.path.parent)
        self.finished = True

    def abandon(self) -> None:
        """Close and remove the unfinished file."""
        self.finished = True
        with suppress(RuntimeError):  # a full disk: what cannot be written is not wanted either
            self._file.close()
        self.partial.unlink(missing_ok=True)


def _texts(record: Mapping[str, Any]) -> dict[str, str]:
    """MCAP's metadata is text: strings as they are, anything else as JSON."""
    return {
        key: value if isinstance(value, str) else json.dumps(value) for key, value in record.items()
    }


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
