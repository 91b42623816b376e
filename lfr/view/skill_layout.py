"""The layout of a demonstration's skills: the arm at the left, both latent spaces at the right."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lfr.view.blueprint import BACKGROUND, EpisodeLayout, arm_view, episode_blueprint, series_view

if TYPE_CHECKING:
    import rerun.blueprint as rrb

Bounds = tuple[tuple[float, float], tuple[float, float]]


def skill_blueprint(layout: EpisodeLayout, bounds: Bounds, transfer: str) -> rrb.Blueprint:
    """The skills first, then all that an episode shows.

    Args:
        layout: of the episode.
        bounds: what the panels of the latent spaces show, horizontally and vertically.
        transfer: whose models speak.
    """
    import rerun.blueprint as rrb

    right = rrb.Vertical(
        _latent_view("source", "Source's latent space", bounds),
        _latent_view("target", "Target's latent space", bounds),
        series_view("KL (nats)", "/skill/divergence"),
        series_view("RMS error of the decoded actions", "/skill/error"),
        rrb.StateTimelineView(origin="/state", name="Gripper and success"),
        row_shares=[2.2, 2.2, 1.1, 1.1, 1.2],
    )
    title = f"{layout.title}: where the next window leads"
    skills = rrb.Horizontal(
        arm_view(title, layout.eye), right, column_shares=[1.3, 1], name=f"Skills of {transfer}"
    )
    plain = episode_blueprint(layout)
    plain.root_container = rrb.Tabs(skills, *plain.root_container.contents, active_tab=0)
    return plain


def _latent_view(space: str, name: str, bounds: Bounds) -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.Spatial2DView(
        origin=f"/latent/{space}",
        name=name,
        visual_bounds=rrb.VisualBounds2D(x_range=bounds[0], y_range=bounds[1]),
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
    )
