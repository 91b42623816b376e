"""H.264 packets as they were encoded, whatever ffmpeg wrote into them when it joined files."""

from __future__ import annotations

from collections.abc import Iterator

OF_MP4 = b"\x01"  # how a setup begins with which units stand behind their lengths
PARAMETER_SETS = (7, 8)  # types of units: of the sequence, of pictures


def without_repeats(packet: bytes, setup: bytes) -> bytes:
    """A packet without the parameter sets that the codec's setup has, too.

    ffmpeg's concat writes them before key frames, and so does LeRobot's converter to v3.0: pictures
    that were copied bit for bit would seem to be encoded anew. (ISO/IEC 14496-15, 5.3.3.)

    Args:
        packet: as it lies in an MP4 file.
        setup: `avcC`; where it is none, the packet is left as it is.
    """
    if setup[:1] != OF_MP4 or len(setup) < 7:
        return packet
    size = (setup[4] & 3) + 1
    return b"".join(unit for unit in _units(packet, size) if not _repeats(unit[size:], setup))


def _units(packet: bytes, size: int) -> Iterator[bytes]:
    """Each with its length before it, in `size` bytes; one that is cut off as it is."""
    at = 0
    while at < len(packet):
        end = at + size + int.from_bytes(packet[at : at + size], "big")
        yield packet[at:end]
        at = end


def _repeats(unit: bytes, setup: bytes) -> bool:
    return bool(unit) and unit[0] & 31 in PARAMETER_SETS and unit in setup
