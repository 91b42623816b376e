"""meta/info.json: lost, cut off, or without what every reader needs; told from the other files."""

from __future__ import annotations

import json
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from lfr.curation.checks.order import TOLERANCE_S
from lfr.curation.contents import DEFAULT_FEATURES, INFO, Contents
from lfr.curation.finding import Unreadable
from lfr.curation.meta_files import write_json
from lfr.curation.mp4 import BrokenVideoError, read_header
from lfr.curation.repair.cut_json import whole_entries
from lfr.curation.repair.draft import Draft, Unmendable
from lfr.curation.repair.features import columns_of, features_of, unnamed
from lfr.data import layout
from lfr.data.source import source_of
from lfr.data.tables import VERSION, files_below, is_older
from lfr.errors import DataError

MOST = 0.9  # of the rows' steps are of one length: a rate is told by them
ORDER = ("codebase_version", "fps", "features", "total_episodes", "total_frames", "total_tasks",
         "chunks_size", "data_files_size_in_mb", "video_files_size_in_mb", "data_path",
         "video_path", "robot_type", "splits")  # fmt: skip


def is_lost(path: Path) -> bool:
    """Whether the folder at `path` is a v3.0 dataset but for its info.json."""
    found, _ = _read(path)
    files = files_below(path / "data", ".parquet") if path.is_dir() else []
    named = files and all(re.fullmatch(r"file-\d+\.parquet", file.name) for file in files)
    return bool(named) and "codebase_version" not in found and not is_older(path)


def can_rebuild(path: Path) -> bool:
    """Whether an info.json that is lost or cut off can be told from the rest; tried aside."""
    try:
        if not is_lost(path) and (not (path / INFO).is_file() or _read(path)[1]):
            return False
        with tempfile.TemporaryDirectory(prefix="lfr-fix-") as folder:
            draft = Draft.of(path, Path(folder))
            mend_info(draft)
            return INFO in draft.changed
    except (Unmendable, Unreadable, DataError, OSError):
        return False


def mend_info(draft: Draft) -> None:
    """Fill in what info.json does not say, the counts aside.

    Raises:
        Unmendable: the rate, the features or the files' names cannot be told.
    """
    found, whole = _read(draft.path)
    if is_older(draft.path) or found.get("codebase_version", VERSION) != VERSION:
        return
    info = {"codebase_version": VERSION, **found}
    contents = Contents(draft.path, info, source_of(draft.path))
    said = [] if whole else ["rebuilt from the other files"]
    unknown: list[str] = []
    if found and not whole:
        said = [f"cut off after {', '.join(found)}; the rest rebuilt from the other files"]
    described = _describe(info, contents, whole)
    if described and whole:
        said.append(f"features {', '.join(described)} described")
    unknown += [f"names of {key}" for key in unnamed(described)]
    fps = _rate(contents)
    if fps is not None and fps != found.get("fps"):
        if "fps" in found:
            said.append(f"fps {fps} in place of {found['fps']!r}")
        elif whole:
            said.append(f"fps {fps}")
        info["fps"] = fps
    if not (whole and isinstance(info.get("data_path"), str) and "video_path" in info):
        _name_files(info, contents, whole)
    if "robot_type" not in info:
        info["robot_type"] = None
        unknown.insert(0, "robot_type")
    if info == found:
        return
    info = {key: info[key] for key in [*ORDER, *info] if key in info}
    with draft.replaced(INFO) as new:
        write_json(new, info, allow_nan=True)
    said += [f"not known, so null: {', '.join(unknown)}"] if unknown else []
    draft.mended(INFO, "; ".join(said or ["names of files"]), unit="")


def _read(path: Path) -> tuple[dict[str, Any], bool]:
    """What info.json holds, and whether it is a whole JSON object."""
    file = path / INFO
    if not file.is_file():
        return {}, False
    text = file.read_bytes().decode("utf-8", "replace")
    try:
        found = json.loads(text)
    except ValueError:
        return whole_entries(text), False
    return (found, True) if isinstance(found, dict) and found else ({}, False)


def _describe(info: dict[str, Any], contents: Contents, whole: bool) -> dict[str, Any]:
    """Add the features that are not described; gives back these."""
    known = info.get("features")
    if isinstance(known, dict) and all(isinstance(f, dict) for f in known.values()) and whole:
        files = contents.data_files
        there = contents.opened(files[0]).schema_arrow.names if files else []
        lacking = [n for n in there if n not in known]
        added = columns_of(contents, lacking) if lacking else {}
    else:
        cut = known if isinstance(known, dict) and not whole else {}
        known = {key: f for key, f in cut.items() if isinstance(f, dict)}
        added = {k: f for k, f in features_of(contents).items() if k not in known}
        _need(contents, {**known, **added})
    info["features"] = {**known, **added}
    return added


def _need(contents: Contents, features: dict[str, Any]) -> None:
    for key in DEFAULT_FEATURES:
        if key not in features:
            raise Unmendable(f"info.json: the rows have no column {key}, which LeRobot needs")


def _rate(contents: Contents) -> float | None:
    """Frames per second, where info.json's are none, or other than those of rows and videos."""
    said = contents.info.get("fps")
    if isinstance(said, bool) or not isinstance(said, int | float) or not said > 0:
        return _rate_of_rows(contents, MOST)
    try:
        rate = _rate_of_rows(contents, 1.0)
    except Unmendable:
        return None
    if abs(rate - said) <= 1e-6 * rate:
        return None
    videos = _rates_of_videos(contents.path)
    return rate if videos and all(abs(v - rate) < 1e-3 * rate for v in videos) else None


def _rate_of_rows(contents: Contents, share: float) -> float:
    """Frames per second by the timestamps, of which this share has to fit."""
    seconds = contents.column("timestamp").astype(np.float64).ravel()
    starts = np.flatnonzero(np.diff(seconds, prepend=np.inf) <= 0)
    lengths = np.diff(starts, append=len(seconds))
    ends = starts + lengths - 1
    long = lengths > 1
    if len(seconds) and long.any():
        steps = (seconds[ends] - seconds[starts])[long] / (lengths[long] - 1)
        step = float(np.median(steps))
        if np.isfinite(step) and step > 0:
            fps = round(1 / step) if abs(1 / step - round(1 / step)) < 2e-4 / step else 1 / step
            rate = fps if isinstance(fps, int) else round(fps, 3)
            off = np.abs(np.diff(seconds) - 1 / rate) > np.maximum(
                TOLERANCE_S, 2 * np.spacing(seconds[1:].astype(np.float32))
            )
            off[starts[starts > 0] - 1] = False
            if rate > 0 and off.sum() <= (1 - share) * len(off):
                return rate
    raise Unmendable("info.json: the rows' timestamps do not go on at one rate: fps is not known")


def _rates_of_videos(path: Path) -> list[float]:
    rates = []
    for file in files_below(path / "videos", ".mp4"):
        try:
            times = read_header(file).times
        except (BrokenVideoError, OSError):
            return []
        if len(times) > 1:
            rates.append((len(times) - 1) / float(times[-1] - times[0]))
    return rates


def _name_files(info: dict[str, Any], contents: Contents, whole: bool) -> None:
    """LeRobot's own names, where the files have these, and its own sizes of files."""
    place = r"/chunk-\d{3,}/file-\d{3,}"
    video = any(f.get("dtype") == "video" for f in info["features"].values())
    for name, default, folder, pattern in (
        ("data_path", layout.DATA_PATH, "data", rf"data{place}\.parquet"),
        ("video_path", layout.VIDEO_PATH, "videos", rf"videos/[^/]+{place}\.mp4"),
    ):
        if isinstance(info.get(name), str):
            continue
        if name == "video_path" and not video:
            info.setdefault(name, None)
            continue
        for file in files_below(contents.path / folder, Path(default).suffix):
            if not re.fullmatch(pattern, contents.relative(file)):
                raise Unmendable(f"info.json: {name} is not known: {contents.relative(file)} is "
                                 "not named as LeRobot names its files")  # fmt: skip
        info[name] = default
    if not whole:
        info.setdefault("chunks_size", layout.CHUNK_SIZE)
        info.setdefault("data_files_size_in_mb", layout.DATA_MEGABYTES)
        info.setdefault("video_files_size_in_mb", layout.VIDEO_MEGABYTES)
