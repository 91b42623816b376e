"""A policy's episode: beside the moving arm, what it chose of what its priors proposed.

At the start of each skill the policy pi'(z | s) = phi(pi(z | s)) (Eq. 7) and the mapped prior
phi(p_a(z | s)) (Eq. 9) are Gaussians over the target's latent space, and the source's prior
p_a(z | s) one over the source's. The two spaces have no dimension in common, so they are drawn in
two panels. On the timelines of `lfr.view.episode`, at the first frame of each skill:

    /latent/target/mapped, /policy, /chosen     LineStrips2D mu - sigma to mu + sigma; Points2D
    /latent/source/prior
    /skill/divergence       Scalars     KL(pi' || phi(p_a)), nats, closed form
    /skill/spread           Scalars     mean sigma of each distribution
    /skill/dimension/<d>    Scalars     z and the means of dimension d
    /path/skills            Points3D    where each skill began
    /path/skill             LineStrips3D  what the present skill does
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import write_whole
from lfr.data.episode import Episode
from lfr.view import series
from lfr.view.episode import end_effector_path, log_episode
from lfr.view.motion import Poses, poses_of
from lfr.view.scene import APPLICATION
from lfr.view.series import Color, frame_times, log_series

if TYPE_CHECKING:
    import rerun as rr

PRIOR_COLOR, MAPPED_COLOR, POLICY_COLOR, CHOSEN_COLOR = (
    series.VIOLET, series.BLUE, series.AMBER, series.WHITE,
)  # fmt: skip

DIMENSION_WIDTH, UNIT = 62.0, 40.0
"""Scene units of the panels per latent dimension (to the right) and per 1.0 of z (upwards)."""

SPAN = 3.0
"""Panels show z in [-SPAN, SPAN]: the VAE's prior is a standard normal distribution."""


@dataclass(frozen=True)
class SkillTrace:
    """The K skills of an episode and the Gaussians they were drawn from; Z latent dimensions.

    Attributes:
        skill_start: (K,) frame at which each skill begins, rising.
        z: (K, Z) the latent that was decoded.
        policy_mu, policy_log_sigma: (K, Z) of the policy pi', in the target's latent space.
        prior_mu, prior_log_sigma: (K, Z) of the source's prior p_a, in the source's.
        mapped_mu, mapped_log_sigma: (K, Z) of phi(p_a), in the target's.

    Raises:
        ValueError: shapes that do not agree.
    """

    skill_start: NDArray[np.int64]
    z: NDArray[np.floating]
    policy_mu: NDArray[np.floating]
    policy_log_sigma: NDArray[np.floating]
    prior_mu: NDArray[np.floating]
    prior_log_sigma: NDArray[np.floating]
    mapped_mu: NDArray[np.floating]
    mapped_log_sigma: NDArray[np.floating]

    def __post_init__(self) -> None:
        expected = (len(self.skill_start), self.latent_dim)
        for field in fields(self)[1:]:
            if (found := getattr(self, field.name).shape) != expected:
                raise ValueError(f"{field.name} has shape {found}, expected {expected}")

    @property
    def latent_dim(self) -> int:
        return self.z.shape[1]

    @property
    def divergence(self) -> NDArray[np.float64]:
        """(K,) KL(pi' || phi(p_a)) in nats, summed over the dimensions (Eq. 9)."""
        gap = (self.policy_mu - self.mapped_mu) ** 2
        ratio = (np.exp(2 * self.policy_log_sigma) + gap) / np.exp(2 * self.mapped_log_sigma)
        log_ratio = self.mapped_log_sigma - self.policy_log_sigma
        return np.sum(log_ratio + 0.5 * ratio - 0.5, axis=1)


def save_policy_episode(
    path: Path, episode: Episode, trace: SkillTrace, poses: Poses | None = None
) -> None:
    """Write a policy's episode and its blueprint to an `.rrd` file, whole."""
    import rerun as rr

    from lfr.view.blueprint import policy_blueprint

    with write_whole(path) as partial, rr.RecordingStream(APPLICATION) as recording:
        recording.save(partial, default_blueprint=policy_blueprint(episode, trace.latent_dim))
        log_policy_episode(recording, episode, trace, poses)
        recording.flush()
        recording.disconnect()


def log_policy_episode(
    recording: rr.RecordingStream,
    episode: Episode,
    trace: SkillTrace,
    poses: Poses | None = None,
) -> None:
    """Log an episode (`lfr.view.episode.log_episode`) and the skills that made it."""
    poses = poses_of(episode) if poses is None else poses
    log_episode(recording, episode, poses)
    log_skill_path(recording, episode, trace, poses)
    log_trace(recording, trace)


def log_skill_path(
    recording: rr.RecordingStream, episode: Episode, trace: SkillTrace, poses: Poses
) -> None:
    """Mark on the end effector's path where each skill began, and what the present one does."""
    import rerun as rr

    path = end_effector_path(episode, poses)
    if path is None:
        return
    ends = [*trace.skill_start[1:], len(path)]
    dots = rr.Points3D(path[trace.skill_start], radii=0.006, colors=series.GREY)
    recording.log("/path/skills", dots, static=True)
    style = rr.LineStrips3D.from_fields(colors=CHOSEN_COLOR, radii=rr.Radius.ui_points(3.0))
    recording.log("/path/skill", style, static=True)
    strips = [path[s : e + 1] for s, e in zip(trace.skill_start, ends, strict=True)]
    columns = rr.LineStrips3D.columns(strips=strips)
    recording.send_columns("/path/skill", indexes=frame_times(trace.skill_start), columns=columns)


def log_trace(recording: rr.RecordingStream, trace: SkillTrace) -> None:
    """Log the Gaussians and the chosen latents, as panels to look at and as series."""
    times, dims = frame_times(trace.skill_start), trace.latent_dim
    legend = {"mapped prior": MAPPED_COLOR, "policy": POLICY_COLOR, "chosen z": CHOSEN_COLOR}
    _log_axes(recording, "/latent/target/axes", dims, legend)
    _log_axes(recording, "/latent/source/axes", dims, {"source prior": PRIOR_COLOR})
    prior, mapped, policy = (
        (trace.prior_mu, trace.prior_log_sigma),
        (trace.mapped_mu, trace.mapped_log_sigma),
        (trace.policy_mu, trace.policy_log_sigma),
    )
    _log_gaussian(recording, "/latent/source/prior", times, *prior, PRIOR_COLOR, 0.0)
    _log_gaussian(recording, "/latent/target/mapped", times, *mapped, MAPPED_COLOR, -9.0)
    _log_gaussian(recording, "/latent/target/policy", times, *policy, POLICY_COLOR, 9.0)
    _log_points(recording, "/latent/target/chosen", times, trace.z, CHOSEN_COLOR, 9.0, 3.4)

    names = ["source prior", "mapped prior", "policy"]
    sigmas = np.stack([np.exp(s).mean(axis=1) for _, s in (prior, mapped, policy)], axis=1)
    colors = [PRIOR_COLOR, MAPPED_COLOR, POLICY_COLOR]
    log_series(recording, "/skill/spread", times, sigmas, names, colors, steps=True)
    label = ["KL(policy || mapped prior)"]
    log_series(
        recording, "/skill/divergence", times, trace.divergence, label, [series.TEAL], steps=True
    )
    for d in range(dims):
        values = np.stack([trace.z[:, d], policy[0][:, d], mapped[0][:, d]], axis=1)
        names = ["chosen z", "policy mean", "mapped mean"]
        colors = [CHOSEN_COLOR, POLICY_COLOR, MAPPED_COLOR]
        path = f"/skill/dimension/{d}"
        log_series(recording, path, times, values, names, colors, steps=True)


def _log_gaussian(
    recording: rr.RecordingStream,
    path: str,
    times: list[rr.TimeColumn],
    mu: NDArray[np.floating],
    log_sigma: NDArray[np.floating],
    color: Color,
    offset: float,
) -> None:
    """A bar from mu - sigma to mu + sigma in each dimension (K, Z), and a dot at mu."""
    import rerun as rr

    low, high = (_place(mu + sign * np.exp(log_sigma), offset) for sign in (-1, 1))
    strips = np.stack([low, high], axis=2)  # (K, Z, 2 ends, 2)
    count, dims = mu.shape
    style = rr.LineStrips2D.from_fields(colors=color, radii=5.0)
    recording.log(f"{path}/spread", style, static=True)
    columns = rr.LineStrips2D.columns(strips=list(strips.reshape(count * dims, 2, 2)))
    recording.send_columns(
        f"{path}/spread", indexes=times, columns=columns.partition([dims] * count)
    )
    dark = (color[0] // 3, color[1] // 3, color[2] // 3)
    _log_points(recording, f"{path}/mean", times, mu, dark, offset, 2.6)


def _log_points(
    recording: rr.RecordingStream,
    path: str,
    times: list[rr.TimeColumn],
    values: NDArray[np.floating],
    color: Color,
    offset: float,
    radius: float,
) -> None:
    import rerun as rr

    count, dims = values.shape
    style = rr.Points2D.from_fields(colors=color, radii=radius, draw_order=40.0)
    recording.log(path, style, static=True)
    positions = _place(values, offset).reshape(-1, 2)
    columns = rr.Points2D.columns(positions=positions).partition([dims] * count)
    recording.send_columns(path, indexes=times, columns=columns)


def _place(values: NDArray[np.floating], offset: float) -> NDArray[np.float64]:
    """Where values (K, Z) of z stand in a panel, (K, Z, 2); its y axis points down."""
    x = np.arange(values.shape[1]) * DIMENSION_WIDTH + offset
    y = -np.clip(values, -SPAN, SPAN) * UNIT
    return np.stack([np.broadcast_to(x, y.shape), y], axis=-1).astype(np.float64)


def _log_axes(
    recording: rr.RecordingStream, path: str, dims: int, legend: dict[str, Color]
) -> None:
    """Lines at whole values of z, named, the number of each dimension below, a legend above."""
    import rerun as rr

    left, right = -0.5 * DIMENSION_WIDTH, (dims - 0.5) * DIMENSION_WIDTH
    levels = np.arange(-SPAN, SPAN + 1)
    lines = [np.array([(left, -level * UNIT), (right, -level * UNIT)]) for level in levels]
    shades = [(110, 116, 128) if level == 0 else (52, 57, 67) for level in levels]
    grid = rr.LineStrips2D(lines, colors=shades, radii=0.5, draw_order=-10.0)
    recording.log(f"{path}/grid", grid, static=True)
    bottom = (SPAN + 0.35) * UNIT
    marks = [(left - 10, -level * UNIT) for level in levels]
    marks += [(d * DIMENSION_WIDTH, bottom) for d in range(dims)]
    words = [f"{level:+.0f}" if level else "0" for level in levels]
    words += [f"z{d}" for d in range(dims)]
    text = rr.Points2D(
        np.array(marks),
        labels=words,
        show_labels=True,
        radii=0.01,
        colors=(150, 155, 165),
        draw_order=-5.0,
    )
    recording.log(f"{path}/names", text, static=True)
    step = (right - left) / len(legend)
    keys = [(left + step * (k + 0.5), -(SPAN + 0.6) * UNIT) for k in range(len(legend))]
    named = rr.Points2D(
        keys, labels=list(legend), show_labels=True, radii=5.0, colors=list(legend.values())
    )
    recording.log(f"{path}/legend", named, static=True)
