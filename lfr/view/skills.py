"""The skill view of a demonstration: its windows in both latent spaces, frame by frame.

On the timelines of `lfr.view.episode`, at each frame from which a whole window is left:

    /latent/source/prior, /window           the source's latent space: LineStrips2D, Points2D
    /latent/target/mapped, /prior, /window  the target's
    /skill/divergence       Scalars     KL of the window from its prior, of G's from the target's
    /skill/error            Scalars     RMS between the window's actions and those decoded
    /path/window, /path/prior, /path/mapped  LineStrips3D, where H translations lead, if an action
                                        is one
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ACTION, Episode
from lfr.embodiments import embodiment
from lfr.view import latent, series
from lfr.view.action import own_action
from lfr.view.collection import Overlay
from lfr.view.latent import log_axes, log_gaussian, log_points
from lfr.view.motion import Poses
from lfr.view.path import end_effector_path
from lfr.view.series import frame_times, log_series
from lfr.view.skill_layout import skill_blueprint
from lfr.view.windows import (
    Gaussians,
    SkillModels,
    WindowTrace,
    action_windows,
    divergence,
    trace_windows,
)

if TYPE_CHECKING:
    import rerun as rr

WINDOW, PRIOR, MAPPED, TARGET = series.WHITE, series.VIOLET, series.BLUE, series.AMBER
PATHS = {"window": ("window", WINDOW), "source prior": ("prior", PRIOR),
         "mapped prior": ("mapped", MAPPED)}  # fmt: skip
"""What was decoded -> the entity below `/path` and the colour of where it leads."""


@dataclass(frozen=True)
class _Bar:
    """A Gaussian in a panel: its entity, its name in the legend, its colour."""

    entity: str
    name: str
    color: series.Color
    values: Gaussians


def skill_overlay(models: SkillModels) -> Overlay:
    """What is shown beside the demonstrations of a task, for `lfr.view.collection`."""
    dims = models.generator.latent_dim
    return Overlay(
        blueprint=lambda layout: skill_blueprint(layout, latent.bounds(dims), models.name),
        log=lambda recording, episode, poses: log_skills(recording, models, episode, poses),
    )


def log_skills(
    recording: rr.RecordingStream, models: SkillModels, episode: Episode, poses: Poses
) -> None:
    """Log what the models make of every window of an episode."""
    trace = trace_windows(models, episode)
    times = frame_times(np.arange(len(trace)))
    for space, bars in panels(trace).items():
        _log_panel(recording, f"/latent/{space}", times, bars, trace)
    names, values = divergences(trace)
    colors = [WINDOW, MAPPED]
    log_series(recording, "/skill/divergence", times, values, names, colors)
    actions = action_windows(episode, models.vaes[trace.arm].horizon)
    errors = [np.sqrt(((part - actions) ** 2).mean(axis=(1, 2))) for part in trace.decoded.values()]
    labels = [f"{name}, decoded" for name in trace.decoded]
    colors = [PATHS[name][1] for name in trace.decoded]
    log_series(recording, "/skill/error", times, np.stack(errors, 1), labels, colors)
    _log_paths(recording, times, trace, episode, poses)


def panels(trace: WindowTrace) -> dict[str, list[_Bar]]:
    """What each of the two latent spaces shows, from left to right."""
    source = [_Bar("prior", "source prior", PRIOR, trace.prior)]
    target = [_Bar("mapped", "G of source prior", MAPPED, trace.mapped)]
    if trace.target_prior is not None:
        target.append(_Bar("prior", "target prior", TARGET, trace.target_prior))
    if trace.arm == "source":
        source.append(_Bar("window", "window", WINDOW, trace.window))
    else:
        target.append(_Bar("window", "window", WINDOW, trace.window))
    if trace.mapped_window is not None:
        target.append(_Bar("window", "G of window", WINDOW, trace.mapped_window))
    return {"source": source, "target": target}


def divergences(trace: WindowTrace) -> tuple[list[str], NDArray[np.float64]]:
    """Names, and (K, N) KL divergences in nats, of what lies in one space and may be compared."""
    found = {}
    own = trace.prior if trace.arm == "source" else trace.target_prior
    if own is not None:
        found[f"window from {trace.arm} prior"] = divergence(trace.window, own)
    if trace.arm == "target":
        found["window from G of source prior"] = divergence(trace.window, trace.mapped)
    elif trace.target_prior is not None:
        found["target prior from G of source prior"] = divergence(trace.target_prior, trace.mapped)
    return list(found), np.stack(list(found.values()), axis=1)


def _log_panel(
    recording: rr.RecordingStream,
    path: str,
    times: list[rr.TimeColumn],
    bars: list[_Bar],
    trace: WindowTrace,
) -> None:
    legend = {bar.name: bar.color for bar in bars}
    log_axes(recording, f"{path}/axes", trace.latent_dim, legend)
    gap = latent.DIMENSION_WIDTH / (len(bars) + 1)
    for number, bar in enumerate(bars):
        place = (number - (len(bars) - 1) / 2) * gap
        where = f"{path}/{bar.entity}"
        log_gaussian(recording, where, times, *bar.values, bar.color, place)
        if bar.entity == "window":
            log_points(
                recording, f"{where}/mean", times, bar.values.mu, bar.color, place, 4.0, order=50.0
            )


def _log_paths(
    recording: rr.RecordingStream,
    times: list[rr.TimeColumn],
    trace: WindowTrace,
    episode: Episode,
    poses: Poses,
) -> None:
    """Where the decoded translations, added up, would lead the end effector from each frame.

    A control step carries an arm over a part of the translation only, since it lags behind its
    goal; which part is measured on the episode itself.
    """
    import rerun as rr
    from scipy.spatial.transform import Rotation

    path, moved = end_effector_path(episode, poses), _translation(episode)
    if path is None or moved is None:
        return
    base = poses[embodiment(episode.robot).robot.base_body][0, 3:]
    axes = Rotation.from_quat(base, scalar_first=True).as_matrix()
    place, size = moved
    action = np.asarray(episode.features[ACTION][:-1, place], np.float64)
    scale = size * carried(size * action @ axes.T, np.diff(path, axis=0))
    starts = path[: len(trace), None]  # (K, 1, 3)
    for name, decoded in trace.decoded.items():
        entity, color = PATHS[name]
        steps = scale * decoded[:, :, place] @ axes.T
        strips = np.concatenate([starts, starts + np.cumsum(steps, axis=1)], axis=1)
        style = rr.LineStrips3D.from_fields(colors=color, radii=rr.Radius.ui_points(2.5))
        recording.log(f"/path/{entity}", style, static=True)
        columns = rr.LineStrips3D.columns(strips=list(strips))
        recording.send_columns(f"/path/{entity}", indexes=times, columns=columns)


def _translation(episode: Episode) -> tuple[slice, float] | None:
    """Where an action translates the hand, and how far a value of 1 does (m); None of joints."""
    action = own_action(episode)
    for quantity, place in action.items() if action else ():
        if quantity.name == "translation":
            return place, quantity.scale[0]  # the same along all three axes
    return None


def carried(wanted: NDArray[np.float64], done: NDArray[np.float64]) -> float:
    """The least-squares factor from the steps wanted (N, 3) to those done (N, 3), in m."""
    square = float(np.sum(wanted * wanted))
    return float(np.sum(wanted * done)) / square if square > 0 else 0.0
