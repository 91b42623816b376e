"""What info.json counts, and what it says of the videos' format."""

from __future__ import annotations

import copy
import re
from contextlib import suppress
from typing import Any

import numpy as np

from lfr.curation.checks.counts import task_words
from lfr.curation.checks.videos import ENCODERS
from lfr.curation.contents import INFO, Contents
from lfr.curation.finding import Unreadable
from lfr.curation.meta_files import write_json
from lfr.curation.mp4 import BrokenVideoError, VideoHeader, read_header
from lfr.curation.repair.draft import Draft, Unmendable
from lfr.curation.repair.rows import episode_lengths
from lfr.data.features import settings_of
from lfr.data.tables import files_below


def mend_counts(draft: Draft) -> None:
    """Count anew in info.json, and describe the videos as their headers do."""
    contents = draft.contents()
    info = copy.deepcopy(contents.info)
    said = _formats(contents, info)
    try:
        said += _totals(draft, contents, info, episode_lengths(contents))
    except Unmendable as reason:
        draft.not_mended(reason)
    except Unreadable:
        pass  # said where they are checked
    if info == contents.info:
        return
    with draft.replaced(INFO) as new:
        write_json(new, info, allow_nan=True)
    for what in said:
        draft.mended(INFO, what, unit="")


def _totals(draft: Draft, contents: Contents, info: dict[str, Any], lengths: Any) -> list[str]:
    if not np.array_equal(contents.lengths, lengths):
        return []  # rows are lost: said where the episodes are mended
    totals = {"total_episodes": len(lengths), "total_frames": int(lengths.sum())}
    with suppress(Unreadable):
        totals["total_tasks"] = len(task_words(contents))
    said = []
    for name, count in totals.items():
        if info.get(name) != count:
            said.append(f"{name} {count}" + (f" in place of {info[name]}" if name in info else ""))
            info[name] = count
    episodes, splits = len(lengths), info.get("splits")
    named = splits if isinstance(splits, dict) else {"train": splits}
    if isinstance(splits, dict) and all(_inside(split, episodes) for split in splits.values()):
        return said
    if named.keys() != {"train"}:
        draft.not_mended("info.json: which episodes are in which of the splits is not known")
        return said
    info["splits"] = {"train": f"0:{episodes}"}
    return [*said, f"splits: train 0:{episodes}"]


def _inside(split: object, episodes: int) -> bool:
    found = re.fullmatch(r"(\d+):(\d+)", str(split))
    return bool(found) and int(found[1]) <= int(found[2]) <= episodes


def _formats(contents: Contents, info: dict[str, Any]) -> list[str]:
    """codec, pixel format and rate of cameras whose files' headers agree on another one."""
    said = []
    for key in contents.pictures("video"):
        settings = settings_of(info["features"][key])
        headers = _headers(contents, key)
        if not headers or not settings:
            continue
        rates = {round(_rate(header), 2) for header in headers}
        for name, there in (
            ("video.codec", {header.codec for header in headers}),
            ("video.pix_fmt", {header.pixels for header in headers}),
            ("video.fps", {contents.fps} if rates == {round(float(contents.fps), 2)} else set()),
        ):
            told = settings.get(name)
            same = ENCODERS.get(told, told) if isinstance(told, str) else told
            if told is None or len(there) != 1 or None in there or same in there:
                continue
            settings[name] = there.pop()
            said.append(f"{key}: {name} {settings[name]} in place of {told}")
    return said


def _headers(contents: Contents, key: str) -> list[VideoHeader]:
    headers = []
    for file in files_below(contents.path / "videos" / key, ".mp4"):
        try:
            headers.append(read_header(file))
        except (BrokenVideoError, OSError):
            return []
    return headers


def _rate(header: VideoHeader) -> float:
    return (header.frames - 1) / float(header.times[-1]) if header.frames > 1 else np.nan
