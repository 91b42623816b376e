"""Many episodes under one name: a dataset's, or a folder's logs, read one at a time.

Opened together they are recordings of one application, so that the viewer lists them under their
collection's name and lays all of them out alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lfr.data.episode import FPS, Episode
from lfr.errors import DataError
from lfr.view.blueprint import EpisodeLayout, episode_blueprint
from lfr.view.dataset import find_log, is_dataset, read_episode
from lfr.view.episode import (
    episode_layout,
    log_episode,
    outcome_of,
    places_seen,
    scene_words,
    seed_of,
)
from lfr.view.eye import eye_on
from lfr.view.motion import Poses, poses_of
from lfr.view.selection import Entry

if TYPE_CHECKING:
    import rerun as rr
    import rerun.blueprint as rrb


@dataclass(frozen=True)
class Collection:
    """Episodes of one dataset or folder.

    Attributes:
        name: what the viewer calls them together.
        fps: frames per second.
        entries: what is known of each, without opening it.
        read: episode `n` with the poses of its bodies; raises DataError where there is none.
        several: there is a next one to step to; a log alone has none.
    """

    name: str
    fps: float
    entries: Callable[[], list[Entry]]
    read: Callable[[int], tuple[Episode, Poses]]
    several: bool = True


@dataclass(frozen=True)
class Overlay:
    """What is shown beside an episode: its layout, and what is logged for it."""

    blueprint: Callable[[EpisodeLayout], rrb.Blueprint]
    log: Callable[[rr.RecordingStream, Episode, Poses], None]


EPISODE_ALONE = Overlay(episode_blueprint, lambda recording, episode, poses: None)


def is_collection(path: Path) -> bool:
    """Whether there are episodes at `path`."""
    if path.is_file():
        return path.suffix == ".mcap"
    return is_dataset(path) or any(path.glob("*.mcap"))


def collection_of(path: Path) -> Collection | None:
    """The episodes at `path`, or None where there is neither a dataset nor a log.

    Raises:
        DataError: a dataset that cannot be read.
    """
    from lfr.data.tables import DatasetFiles
    from lfr.view.listing import dataset_entries, log_entries

    name = path.resolve().name
    if not is_collection(path):
        return None
    if path.is_dir() and is_dataset(path):
        fps = DatasetFiles.open(path).fps
        return Collection(name, fps, partial(dataset_entries, path), partial(_of_dataset, path))
    logs = [path] if path.is_file() else sorted(path.glob("*.mcap"))
    entries, read = partial(log_entries, logs), partial(_of_logs, logs, path)
    return Collection(name, FPS, entries, read, several=not path.is_file())


def save_episodes(
    collection: Collection,
    numbers: Sequence[int],
    folder: Path,
    *,
    overlay: Overlay = EPISODE_ALONE,
    at: float | None = None,
) -> list[Path]:
    """Write each episode to an `.rrd` file in `folder`: recordings of one application.

    Args:
        collection: where they are.
        numbers: of the episodes.
        folder: a temporary one, that gets `episode-<number>.rrd`.
        overlay: what is shown beside them.
        at: s; the viewer stands there instead of playing.

    Raises:
        DataError: an episode that is not there, or cannot be shown.
    """
    import rerun as rr

    folder.mkdir(parents=True, exist_ok=True)
    episodes = [collection.read(number) for number in numbers]
    layout = shared_layout(episodes)
    files = []
    for number, (episode, poses) in zip(numbers, episodes, strict=True):
        blueprint = overlay.blueprint(layout)
        arrange(blueprint, choice=len(numbers) > 1, at=at)
        file = folder / f"episode-{number:06d}.rrd"
        # The identity is the episode's, so that one sent to a viewer twice is there once.
        with rr.RecordingStream(collection.name, recording_id=f"episode-{number}") as recording:
            recording.save(file, default_blueprint=blueprint)
            log_episode(recording, episode, poses, listed_name(number, episode))
            overlay.log(recording, episode, poses)
            recording.flush()
            recording.disconnect()
        files.append(file)
    return files


def listed_name(number: int, episode: Episode) -> str:
    """For the viewer's list, which shows some fifteen letters: `12 success · seed 3 ...`."""
    first = " ".join(word for word in (str(number), outcome_of(episode)) if word)
    return " · ".join(word for word in (first, seed_of(episode), *scene_words(episode)) if word)


def shared_layout(episodes: Sequence[tuple[Episode, Poses]]) -> EpisodeLayout:
    """A layout for all of them: that of the first, its eye on everything that moves in any."""
    first, poses = episodes[0]
    seen = np.concatenate([places_seen(episode, each) for episode, each in episodes])
    eye, title = eye_on(seen) if len(seen) else None, " · ".join(scene_words(first))
    return replace(episode_layout(first, poses), title=title or "Episode", eye=eye)


def arrange(blueprint: rrb.Blueprint, *, choice: bool, at: float | None) -> None:
    """Open the list of recordings where there is a choice; stand still at `at` (s) if given."""
    import rerun.blueprint as rrb

    if choice:
        blueprint.blueprint_panel = rrb.BlueprintPanel(state="expanded")
    if at is not None:
        # rerun's blueprints hold no moment: a loop without length is one.
        moment = round(1e9 * at)
        blueprint.time_panel = rrb.TimePanel(
            state="collapsed",
            timeline="time",
            loop_mode="Selection",
            play_state="Playing",
            time_selection=rrb.components.AbsoluteTimeRange(moment, moment),
        )


def _of_dataset(path: Path, number: int) -> tuple[Episode, Poses]:
    from lfr.data.log_reader import read_log

    episode = read_episode(path, number)
    if log := find_log(path, episode):
        episode = replace(episode, cameras=read_log(log).cameras)
    return episode, poses_of(episode, log)


def _of_logs(logs: Sequence[Path], path: Path, number: int) -> tuple[Episode, Poses]:
    from lfr.data.log_reader import read_log

    if not 0 <= number < len(logs):
        raise DataError("no such episode", file=path, episode=number,
                        expected=f"0 to {len(logs) - 1}")  # fmt: skip
    episode = read_log(logs[number])
    return episode, poses_of(episode, logs[number])
