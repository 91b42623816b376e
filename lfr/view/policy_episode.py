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

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lfr.artifacts import write_whole
from lfr.data.episode import Episode
from lfr.view import latent, series
from lfr.view.blueprint import policy_blueprint
from lfr.view.episode import episode_layout, log_episode
from lfr.view.latent import log_axes, log_gaussian, log_points
from lfr.view.motion import Poses, poses_of
from lfr.view.path import end_effector_path
from lfr.view.series import frame_times, log_series
from lfr.view.trace import SkillTrace

if TYPE_CHECKING:
    import rerun as rr

PRIOR_COLOR, MAPPED_COLOR, POLICY_COLOR, CHOSEN_COLOR = (
    series.VIOLET, series.BLUE, series.AMBER, series.WHITE,
)  # fmt: skip


def save_policy_episode(
    path: Path,
    episode: Episode,
    trace: SkillTrace,
    poses: Poses | None = None,
    note: str | None = None,
) -> None:
    """Write a policy's episode and its blueprint to an `.rrd` file, whole.

    Args:
        path: the file.
        episode: T frames.
        trace: the skills that made it.
        poses: of the bodies, found out from the episode by default.
        note: before its title, such as how far the policy had learned.
    """
    import rerun as rr

    poses = poses_of(episode) if poses is None else poses
    layout, dims = episode_layout(episode, poses, note), trace.latent_dim
    blueprint = policy_blueprint(layout, dims, latent.bounds(dims))
    with write_whole(path) as partial, rr.RecordingStream(layout.title) as recording:
        recording.save(partial, default_blueprint=blueprint)
        log_episode(recording, episode, poses, layout.title)
        log_skill_path(recording, episode, trace, poses)
        log_trace(recording, trace)
        recording.flush()
        recording.disconnect()


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
    log_axes(recording, "/latent/target/axes", dims, legend)
    log_axes(recording, "/latent/source/axes", dims, {"source prior": PRIOR_COLOR})
    prior, mapped, policy = (
        (trace.prior_mu, trace.prior_log_sigma),
        (trace.mapped_mu, trace.mapped_log_sigma),
        (trace.policy_mu, trace.policy_log_sigma),
    )
    log_gaussian(recording, "/latent/source/prior", times, *prior, PRIOR_COLOR, 0.0)
    log_gaussian(recording, "/latent/target/mapped", times, *mapped, MAPPED_COLOR, -9.0)
    log_gaussian(recording, "/latent/target/policy", times, *policy, POLICY_COLOR, 9.0)
    log_points(
        recording, "/latent/target/chosen", times, trace.z, CHOSEN_COLOR, 9.0, 4.0, order=50.0
    )

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
