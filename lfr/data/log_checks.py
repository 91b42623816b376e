"""Whether a log belongs to the dataset that it is packed into, and is fit for one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lfr.data.episode import Episode
from lfr.errors import DataError


@dataclass(frozen=True)
class LogKind:
    """What the logs of one dataset have in common: what the first of them has.

    Attributes:
        log: the first one's file, named in errors.
        episode: what it holds: robot, task, and the names of each feature.
        cameras: those that are packed; a log may have others.
        fps: frames per second.
    """

    log: Path
    episode: Episode
    cameras: tuple[str, ...]
    fps: int

    def check(self, episode: Episode, log: Path, index: int) -> None:
        """Refuse an episode, read from `log`, that is not fit to be number `index`.

        Raises:
            DataError: it is of another kind; a value is not finite.
        """
        self.check_kind(episode, log, index)
        _check_finite(episode, log, index)

    def check_kind(self, episode: Episode, log: Path, index: int) -> None:
        """Refuse an episode that is not of this kind.

        Raises:
            DataError: another robot, task, rate or name, or a camera is missing.
        """
        schema, first = episode.schema, self.episode
        pairs = {
            "robot": (episode.robot, first.robot),
            "task": (episode.task, first.task),
            "fps": (episode.metadata["fps"], self.fps),
            "cameras": (sorted(set(self.cameras) & set(episode.images)), sorted(self.cameras)),
            **{
                key: (schema[key].names, f.names)
                for key, f in first.schema.items()
                if key in schema
            },
        }
        for column, (found, expected) in pairs.items():
            if found != expected:
                raise DataError(
                    f"a log of another kind than {self.log.name}",
                    file=log,
                    episode=index,
                    column=column,
                    found=found,
                    expected=expected,
                )


def _check_finite(episode: Episode, log: Path, index: int) -> None:
    for key, values in episode.features.items():
        if not np.isfinite(values).all():
            raise DataError(
                "a value that is not finite",
                file=log,
                episode=index,
                column=key,
                found=f"{values[~np.isfinite(values)][0]}",
                expected="finite numbers",
            )
