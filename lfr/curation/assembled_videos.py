"""The videos of a new dataset: one file for each stretch of neighbouring episodes of an old one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.clips import Clip, write_clip
from lfr.curation.finding import readable
from lfr.curation.parts import Source, files_per_chunk, new_file
from lfr.data.features import settings_of


def write_videos(
    out: Path, sources: Sequence[Source], key: str, how: dict[str, int]
) -> dict[str, NDArray]:
    """Write a camera's files of a new dataset at `out`.

    Args:
        out: the new dataset's folder.
        sources: its episodes.
        key: of the camera's feature.
        how: counts of the clips copied, cut and encoded, which this one adds to.

    Returns:
        The columns of meta/episodes that say where each episode is.

    Raises:
        DataError: a video that is broken, or ends before its episodes do.
    """
    model = sources[0].contents
    clips: list[Clip] = []
    files: list[int] = []  # of each episode
    firsts: list[int] = []  # of each episode's frames, in its file
    for clip in _clips(sources, key):
        if clips and clips[-1].followed_by(clip):
            firsts.append(clips[-1].frames)
            clips[-1] = clips[-1].joined(clip)
        else:
            firsts.append(0)
            clips.append(clip)
        files.append(len(clips) - 1)
    for number, clip in enumerate(clips):
        path = new_file(out, model, "video_path", number, video_key=key)
        how[write_clip(clip, path, model.fps, settings_of(model.features[key]))] += 1
    chunk, file = np.divmod(np.array(files), files_per_chunk(model))
    first, lengths = np.array(firsts), np.concatenate([source.lengths for source in sources])
    return {
        f"videos/{key}/chunk_index": chunk,
        f"videos/{key}/file_index": file,
        f"videos/{key}/from_timestamp": first / model.fps,
        f"videos/{key}/to_timestamp": (first + lengths) / model.fps,
    }


def shared_settings(sources: Sequence[Source], key: str) -> dict[str, Any]:
    """A camera's `info`: what the parts do not share is null, as in LeRobot's own merging."""
    infos = [settings_of(source.contents.features[key]) for source in sources]
    return {
        name: value if all(info.get(name) == value for info in infos) else None
        for name, value in infos[0].items()
    }


def _clips(sources: Sequence[Source], key: str) -> Iterator[Clip]:
    for source in sources:
        contents = source.contents
        with readable(source.path):
            prefix = f"videos/{key}"
            chunk, file = contents.placed(prefix, source.positions)
            start = contents.episode_column(f"{prefix}/from_timestamp", source.positions)
            for c, f, begin, length in zip(
                chunk.tolist(), file.tolist(), start.tolist(), source.lengths.tolist(), strict=True
            ):
                name = contents.named("video_path", video_key=key, chunk_index=c, file_index=f)
                first = round(float(begin) * contents.fps)
                yield Clip(source.path / name, first, length)
