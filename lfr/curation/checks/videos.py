"""Videos against the rows: whole files, as many frames as rows, at the times that rows have."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lfr.curation.checks.order import TOLERANCE_S
from lfr.curation.contents import EPISODES, Contents, at_episodes
from lfr.curation.finding import Finding, first
from lfr.curation.mp4 import BrokenVideoError, VideoHeader, read_header
from lfr.data.features import names_of, settings_of, shape_of

ENCODERS = {"libsvtav1": "av1", "libaom-av1": "av1", "libx264": "h264", "avc1": "h264",
            "h265": "hevc", "libx265": "hevc"}  # fmt: skip
"""What info.json may call a codec besides its name."""


def check_videos(contents: Contents) -> Iterator[Finding]:
    """Every camera's files, by their headers alone: no frame is decoded."""
    for key in contents.pictures():
        prefix = f"videos/{key}/"
        start, end = (
            contents.episode_column(prefix + name) for name in ("from_timestamp", "to_timestamp")
        )
        found = np.rint((end - start) * contents.fps)
        if (wrong := found != contents.lengths).any():
            at, where = at_episodes(wrong)
            yield Finding("video-frames", "another number of frames than rows", file=EPISODES,
                          column=prefix + "to_timestamp", found=int(found[at]),
                          expected=int(contents.lengths[at]), **where)  # fmt: skip
        for name, episodes in contents.placed_in(f"videos/{key}").items():
            if not (contents.path / name).is_file():
                continue  # said where files are checked
            try:
                header = read_header(contents.path / name)
            except BrokenVideoError as error:
                _, where = at_episodes(episodes)
                yield Finding("damaged-file", "a video that does not play", file=name, column=key,
                              found=str(error), expected="a whole MP4 file", **where)  # fmt: skip
                continue
            yield from _format(contents, key, name, header, episodes)
            yield from _times(contents, name, key, header, episodes, start, end)
            yield from _places(contents, name, key, header, episodes, start, end)


def _format(
    contents: Contents, key: str, name: str, header: VideoHeader, episodes: np.ndarray
) -> Iterator[Finding]:
    feature = contents.features[key]
    named: dict[str, int] = dict(zip(names_of(feature), shape_of(feature), strict=False))
    expected = (named.get("height"), named.get("width"))
    if None not in expected and (header.height, header.width) != expected:
        yield Finding("shape", "a video of another size than info.json says", file=name, column=key,
                      found=(header.height, header.width), expected=expected,
                      episodes=tuple(episodes.tolist()))  # fmt: skip
    for setting, said in (("video.codec", header.codec), ("video.pix_fmt", header.pixels)):
        told = settings_of(feature).get(setting)
        told = ENCODERS.get(told, told) if isinstance(told, str) else None
        if told is not None and said is not None and told != said:
            yield Finding("format", "a video in another format than info.json says", "warning",
                          name, column=f"{key}: {setting}", found=said, expected=told)  # fmt: skip
    fps = settings_of(feature).get("video.fps")
    if fps is not None and fps != contents.fps:
        yield Finding("fps", "a video at another rate than the rows", file="meta/info.json",
                      column=key, found=fps, expected=contents.fps)  # fmt: skip


def _times(
    contents: Contents,
    name: str,
    key: str,
    header: VideoHeader,
    episodes: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
) -> Iterator[Finding]:
    """Its frames follow one another by 1 / fps."""
    # Containers keep times in whole ticks, so two neighbours may differ by one.
    steps = np.diff(header.times)
    wrong = np.abs(steps - 1 / contents.fps) > max(2e-3 / contents.fps, TOLERANCE_S)
    if wrong.any():
        at, places = first(wrong)
        before = np.concatenate([[0], np.cumsum(wrong)])  # steps up to each frame that are wrong
        first_frame, end_frame = (
            np.clip(np.rint(times[episodes] * contents.fps).astype(int), 0, len(steps))
            for times in (start, end)
        )
        reached = before[end_frame] > before[np.maximum(first_frame - 1, 0)]
        where = {"file": name, "column": key, "found": float(steps[at]),
                 "expected": 1 / contents.fps, "places": places,
                 "episodes": tuple(episodes[reached].tolist())}  # fmt: skip
        if places == len(steps):
            yield Finding("fps", "a video at another rate than the rows", **where)
        else:
            yield Finding("gap-in-time", f"a gap after frame {at} of the video", **where)


def _places(
    contents: Contents,
    name: str,
    key: str,
    header: VideoHeader,
    episodes: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
) -> Iterator[Finding]:
    """Episodes share a file without gap, overlap or rest."""
    first_frame = np.rint(start[episodes] * contents.fps).astype(int)
    end_frame = np.rint(end[episodes] * contents.fps).astype(int)
    order = np.argsort(first_frame, kind="stable")
    off = np.abs(start[episodes] * contents.fps - first_frame) > TOLERANCE_S * contents.fps
    if off.any():
        at, where = at_episodes(episodes[off])
        yield Finding("video-frames", "an episode that starts between two frames", file=name,
                      column=f"videos/{key}/from_timestamp", found=float(start[at]),
                      expected=float(np.rint(start[at] * contents.fps) / contents.fps),
                      **where)  # fmt: skip
    beyond = end_frame > header.frames
    if beyond.any():
        _, where = at_episodes(episodes[beyond])
        yield Finding("video-frames", "the video ends before the episode", file=name, column=key,
                      found=header.frames, expected=int(end_frame[beyond.argmax()]),
                      **where)  # fmt: skip
    overlap = first_frame[order][1:] < end_frame[order][:-1]
    if overlap.any():
        at = int(overlap.argmax())
        _, where = at_episodes(episodes[order][1:][overlap])
        yield Finding("video-frames", "an episode that shows another one's frames", file=name,
                      column=key, found=int(first_frame[order][at + 1]),
                      expected=int(end_frame[order][at]), **where)  # fmt: skip
    used = int((end_frame - first_frame).sum())
    if header.frames > used and not beyond.any() and not overlap.any():
        yield Finding("video-frames", "frames that belong to no episode", "warning", name,
                      column=key, found=header.frames, expected=used)  # fmt: skip
