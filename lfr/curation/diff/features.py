"""What the two datasets say of themselves: features, rates, robot, videos, columns of episodes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from lfr.curation.contents import INFO
from lfr.curation.diff.difference import Difference
from lfr.curation.diff.side import Side
from lfr.data.features import names_of, settings_of

COUNTED = ("total_", "chunks_size", "data_path", "video_path", "features", "splits",
           "data_files_size_in_mb", "video_files_size_in_mb")  # fmt: skip
"""Entries of info.json that say how much there is and how it is laid out."""

VIDEO = ("video.codec", "video.pix_fmt", "video.height", "video.width", "video.fps",
         "is_depth_map")  # fmt: skip

NUMBERED = ("episode_index", "length", "dataset_from_index", "dataset_to_index")
PLACES = ("data/", "videos/", "meta/episodes/", "stats/")
"""Columns of meta/episodes that say where an episode is or follow from its rows, and how others
begin."""


def compare_features(a: Side, b: Side) -> Iterator[Difference]:
    """Of info.json and of the columns of meta/episodes."""
    yield from _info(a, b)
    ours, theirs = a.contents.features, b.contents.features
    for key in ours:
        if key not in theirs:
            yield Difference("feature", "a feature that B has not", column=key)
        else:
            yield from _feature(key, ours[key], theirs[key])
    for key in theirs:
        if key not in ours:
            yield Difference("feature", "a feature that A has not", column=key)
    yield from _columns(a, b)


def kept_columns(side: Side) -> list[str]:
    """Columns of meta/episodes that say something of an episode, but for its statistics."""
    names = side.contents.episodes.column_names
    return [name for name in names if name not in NUMBERED and not name.startswith(PLACES)]


def _info(a: Side, b: Side) -> Iterator[Difference]:
    ours, theirs = a.contents.info, b.contents.info
    for key in dict.fromkeys((*ours, *theirs)):
        found = ours.get(key), theirs.get(key)
        if not key.startswith(COUNTED) and found[0] != found[1]:
            yield Difference("info", f"another {key} in {INFO}", column=key, a=found[0],
                             b=found[1])  # fmt: skip
    splits = _splits(ours, len(a)), _splits(theirs, len(b))
    if splits[0] != splits[1]:
        yield Difference("info", "other splits", column="splits", a=ours.get("splits"),
                         b=theirs.get("splits"))  # fmt: skip


def _splits(info: Mapping[str, Any], episodes: int) -> Any:
    """What info.json has, but for the one split that is all of it."""
    splits = info.get("splits")
    return None if splits in ({"train": f"0:{episodes}"}, {}) else splits


def _feature(key: str, a: Mapping[str, Any], b: Mapping[str, Any]) -> Iterator[Difference]:
    for name in ("dtype", "shape"):
        if a.get(name) != b.get(name):
            yield Difference("feature", f"another {name}", column=key, a=a.get(name),
                             b=b.get(name))  # fmt: skip
    names = names_of(a), names_of(b)
    if names[0] != names[1]:
        order = sorted(names[0]) == sorted(names[1])
        message = "the names of its dimensions in another order" if order else "other names"
        yield Difference("feature", message, column=key, a=", ".join(names[0]),
                         b=", ".join(names[1]))  # fmt: skip
    settings = settings_of(a), settings_of(b)
    for name in VIDEO:
        found = [each.get(name) for each in settings]
        if None not in found and found[0] != found[1]:
            yield Difference("video", "videos of another kind", column=f"{key}: {name}",
                             a=found[0], b=found[1])  # fmt: skip


def _columns(a: Side, b: Side) -> Iterator[Difference]:
    """Of meta/episodes; the statistics of a feature count as one."""
    both = set(a.contents.features) & set(b.contents.features)
    if a.contents.source.is_older or b.contents.source.is_older:
        both = set()  # which has them elsewhere, v2.0 none of an episode
    ours, theirs = (_names(side, both) for side in (a, b))
    message = "a column of meta/episodes that {} has not"
    for name in ours:
        if name not in theirs:
            yield Difference("episode-column", message.format("B"), column=name)
    for name in theirs:
        if name not in ours:
            yield Difference("episode-column", message.format("A"), column=name)


def _names(side: Side, features: Collection[str]) -> list[str]:
    names = side.contents.episodes.column_names
    stats = (n.removeprefix("stats/").rpartition("/")[0] for n in names if n.startswith("stats/"))
    of_features = dict.fromkeys(f"stats/{key}" for key in stats if key in features)
    return [*kept_columns(side), *of_features]
