"""The writer of a dataset of bags: a bag's second reading, by `lfr.data`'s own writers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import file_hash
from lfr.data.episode import Feature
from lfr.data.frames import FrameWriter
from lfr.data.layout import video_path
from lfr.data.meta import MetaWriter
from lfr.errors import ParameterError
from lfr.importing.bag.episodes import BagPlan
from lfr.importing.bag.fill import Filled, Size, fill
from lfr.importing.bag.mapping import BagMapping, Part
from lfr.importing.bag.parts import PartReader

Values = dict[str, NDArray[np.float32]]


class BagWriter:
    """Writes data, videos and meta into an empty folder, a bag at a time.

    Attributes:
        features: of the dataset, pictures aside.
        wrong: of each bag, episode -> why it cannot be one; while there are none.
        written: each episode's bag and values.
        bags: path -> SHA-256.
    """

    def __init__(self, root: Path, mapping: BagMapping, readers: Mapping[Part, PartReader]) -> None:
        from lfr.data.video import VideoWriter

        self._mapping, self._readers = mapping, readers
        self.features = features_of(mapping, readers)
        self._entries: dict[str, dict[str, Any]] = {
            key: {"dtype": f.dtype, "shape": f.shape, "names": list(f.names or ())}
            for key, f in self.features.items()
        }
        self.frames = FrameWriter(root, self._entries, mapping.fps)
        self._meta = MetaWriter(root, mapping.robot_type, mapping.fps)
        self._videos = {
            key: VideoWriter(root, key, video_path(key), mapping.fps) for key in mapping.cameras
        }
        self.wrong: list[dict[int, str]] = []
        self.written: list[tuple[Path, Values]] = []
        self.bags: dict[Path, str] = {}
        self._sizes: list[dict[str, dict[int, Size]]] = []

    def add(self, plan: BagPlan) -> None:
        """Read a bag's frames, and write them unless one was wrong."""
        if not plan.episodes:
            self.wrong.append({})
            self._sizes.append({})
            return
        videos = None if any(self.wrong) else self._videos
        filled = fill(plan, self._readers, self._mapping.cameras, videos)
        self.wrong.append(filled.wrong)
        self._sizes.append(filled.sizes)
        path = plan.index.bag.path
        self.bags[path] = file_hash(path)
        if any(self.wrong) or any(len(v) < len(plan.episodes) for v in filled.videos.values()):
            return
        steps = np.cumsum([0, *(episode.steps for episode in plan.episodes)])
        for number, episode in enumerate(plan.episodes):
            rows = slice(int(steps[number]), int(steps[number + 1]))
            features = self._values(filled, rows, episode.frames)
            where: dict[str, Any]
            where, stats = self.frames.write(features, self._meta.task_index(episode.task))
            for key, found in filled.videos.items():
                place, stats[key] = found[number]
                where |= place
            columns = {
                "source_file": path.name,
                "source_sha256": self.bags[path],
                "source_start_ns": episode.start,
            }
            self._meta.add(episode.frames, episode.task, where, columns, stats)
            self.written.append((path, features))

    def compare_sizes(self, plans: Sequence[BagPlan]) -> None:
        """Pictures of another size than most of a camera's make their episodes wrong."""
        for key in self._mapping.cameras:
            counts: Counter[Size] = Counter()
            for plan, sizes in zip(plans, self._sizes, strict=True):
                for number, size in sizes.get(key, {}).items():
                    counts[size] += plan.episodes[number].frames
            usual = max(counts, key=lambda size: counts[size], default=(0, 0))
            for wrong, sizes in zip(self.wrong, self._sizes, strict=True):
                for number, size in sizes.get(key, {}).items():
                    if size != usual:
                        wrong.setdefault(number, f"{key}: pictures of {size[0]} x {size[1]}, not "
                                         f"{usual[0]} x {usual[1]} as most are")  # fmt: skip

    def close(self) -> None:
        self.frames.close()
        for video in self._videos.values():
            video.close()

    def finish(self) -> None:
        """Close the files and write all of meta."""
        self.close()
        entries = {key: video.feature() for key, video in self._videos.items()}
        stats = {key: video.stats for key, video in self._videos.items()}
        self._meta.write(self._entries | entries, self.frames.stats | stats)

    def _values(self, filled: Filled, rows: slice, frames: int) -> Values:
        whole = {
            key: np.concatenate([filled.values[part][rows] for part in parts], axis=1)
            for key, parts in self._mapping.numbers.items()
        }
        values = {key: steps[:frames] for key, steps in whole.items()}
        for key, of in self._mapping.nexts.items():
            names = self.features[of.next].names or ()
            columns = [names.index(name) for name in self.features[key].names or ()]
            values[key] = whole[of.next][1 : frames + 1, columns]
        single = {key: v.astype(np.float32) for key, v in values.items()}
        return {key: single[key][:, 0] if len(feature.names or ()) == 1 else single[key]
                for key, feature in self.features.items()}  # fmt: skip


def features_of(mapping: BagMapping, readers: Mapping[Part, PartReader]) -> dict[str, Feature]:
    """The features that are numbers, in the order of the mapping.

    Raises:
        ParameterError: a feature has a dimension twice, or takes one that the other has not.
    """
    names = {key: tuple(name for part in parts for name in readers[part].dimensions)
             for key, parts in mapping.numbers.items()}  # fmt: skip
    for key, found in names.items():
        if twice := [name for name, count in Counter(found).items() if count > 1]:
            raise ParameterError(f"{key}: {', '.join(twice)} twice; a prefix tells them apart")
    for key, of in mapping.nexts.items():
        if of.names is not None and (unknown := set(of.names) - set(names[of.next])):
            raise ParameterError(f"{key}: no {', '.join(sorted(unknown))} in {of.next}; valid: "
                                 f"{', '.join(names[of.next])}")  # fmt: skip
        names[key] = of.names or names[of.next]
    return {key: Feature(key, "float32", names[key], "") for key in mapping.features
            if key in names}  # fmt: skip
