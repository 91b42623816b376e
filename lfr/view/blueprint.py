"""How each kind of recording is laid out: 3-D large at the left, camera and series at the right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lfr.data.episode import ENVIRONMENT_STATE, STATE, Episode

if TYPE_CHECKING:
    import rerun.blueprint as rrb

# The eye stands before the table, a little to its side and above: the hand and the objects are
# nearest, and the arm does not hide them. All four arenas have the table or the bins around x = 0
# and the arm behind it at x = -0.55 (m, world).
EYE = (0.95, -0.85, 1.52)
LOOK_AT = (-0.19, 0.0, 1.03)
BACKGROUND = (22, 25, 31)


def arm_view(name: str = "Scene") -> rrb.Spatial3DView:
    """The arm, its task and its path in 3-D."""
    import rerun.blueprint as rrb

    return rrb.Spatial3DView(
        origin="/",
        contents=["/world/**", "/path/**"],
        name=name,
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
        line_grid=rrb.LineGrid3D(
            visible=True, spacing=0.5, stroke_width=0.6, color=(70, 76, 88, 110)
        ),
        eye_controls=rrb.EyeControls3D(kind="Orbital", position=EYE, look_target=LOOK_AT),
    )


def series_view(
    name: str,
    contents: str | Sequence[str],
    span: tuple[float, float] | None = None,
    *,
    legend: bool = True,
) -> rrb.TimeSeriesView:
    """Curves over time; `span` fixes the vertical axis."""
    import rerun.blueprint as rrb

    return rrb.TimeSeriesView(
        origin="/",
        contents=[contents] if isinstance(contents, str) else list(contents),
        name=name,
        axis_y=rrb.ScalarAxis(range=span) if span else None,
        plot_legend=rrb.PlotLegend(corner="RightTop", visible=legend),
    )


def camera_views(cameras: Sequence[str]) -> list[rrb.View]:
    """One view for each camera."""
    import rerun.blueprint as rrb

    return [rrb.Spatial2DView(origin=f"/camera/{camera}", name=camera) for camera in cameras]


def episode_blueprint(episode: Episode) -> rrb.Blueprint:
    """Arm and path at the left; camera, success, action, gripper and reward at the right."""
    import rerun.blueprint as rrb

    return rrb.Blueprint(
        rrb.Tabs(_episode_tab(episode), _observation(episode), _about(), active_tab=0),
        *_panels("time"),
    )


def _episode_tab(episode: Episode) -> rrb.Container:
    import rerun.blueprint as rrb

    from lfr.view.episode import episode_title

    cameras = camera_views(list(episode.images))
    series = [
        rrb.StateTimelineView(origin="/state", name="Gripper and success"),
        series_view("Action: translation (× 5 cm)", "/action/translation", (-1.05, 1.05)),
        series_view("Action: rotation (× 0.5 rad)", "/action/rotation", (-1.05, 1.05)),
        series_view("Gripper", ["/action/gripper", "/gripper"], (-1.05, 1.05)),
        series_view("Reward", "/reward", legend=False),
    ]
    right = rrb.Vertical(*cameras, *series, row_shares=[*[2.6] * len(cameras), 0.9, 1, 1, 1, 1])
    return rrb.Horizontal(
        arm_view(episode_title(episode)), right, column_shares=[2.1, 1], name="Episode"
    )

    overview = rrb.Horizontal(
        arm_view(episode_title(episode)), right, column_shares=[2.1, 1], name="Episode"
    )
    return rrb.Blueprint(
        rrb.Tabs(overview, _observation(episode), _about(), active_tab=0),
        *_panels("time"),
    )


def policy_blueprint(episode: Episode, latent_dim: int) -> rrb.Blueprint:
    """Arm at the left; the latents of the present skill, divergence and success at the right."""
    import rerun.blueprint as rrb

    from lfr.view.episode import episode_title

    right = rrb.Vertical(
        _latent_view("target", "Target's latent space: mapped prior, policy, chosen z", latent_dim),
        _latent_view("source", "Source's latent space: its prior", latent_dim),
        series_view("Divergence of the policy from the mapped prior (nats)", "/skill/divergence"),
        series_view("Mean spread", "/skill/spread"),
        rrb.StateTimelineView(origin="/state", name="Gripper and success"),
        row_shares=[2.3, 2.3, 0.9, 0.9, 1.2],
    )
    overview = rrb.Horizontal(
        arm_view(episode_title(episode)), right, column_shares=[1.6, 1], name="Policy"
    )
    dimensions = [series_view(f"z{d}", f"/skill/dimension/{d}") for d in range(latent_dim)]
    skills = rrb.Grid(*dimensions, name="Latent dimensions")
    return rrb.Blueprint(
        rrb.Tabs(overview, skills, _episode_tab(episode), _about(), active_tab=0),
        *_panels("time"),
    )


def _latent_view(space: str, name: str, latent_dim: int) -> rrb.View:
    import rerun.blueprint as rrb

    from lfr.view.policy import DIMENSION_WIDTH, SPAN, UNIT

    bounds = rrb.VisualBounds2D(
        x_range=(-1.1 * DIMENSION_WIDTH, (latent_dim - 0.4) * DIMENSION_WIDTH),
        y_range=(-(SPAN + 1.0) * UNIT, (SPAN + 1.0) * UNIT),
    )
    return rrb.Spatial2DView(
        origin=f"/latent/{space}",
        name=name,
        visual_bounds=bounds,
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
    )


def learning_blueprint() -> rrb.Blueprint:
    """Success large; return, divergence, temperature, values and losses around it."""
    import rerun.blueprint as rrb

    first = rrb.Horizontal(
        series_view("Success", ["/evaluation/success", "/learning/success"], (-0.02, 1.02)),
        rrb.Vertical(
            series_view("Return", "/evaluation/return", legend=False),
            series_view("Episode length (control steps)", "/evaluation/length", legend=False),
        ),
        column_shares=[2, 1],
    )
    second = rrb.Horizontal(
        series_view("Divergence from the mapped prior (nats)", ["/update/kl"], legend=False),
        series_view("Temperature", "/update/alpha", legend=False),
        series_view("Spread of the policy", "/update/sigma", legend=False),
        series_view("Q", "/update/q", legend=False),
        series_view("Losses", ["/update/critic_loss", "/update/policy_loss"]),
    )
    return rrb.Blueprint(
        rrb.Vertical(first, second, row_shares=[1.6, 1], name="Learning"), *_panels("env_steps")
    )


def _observation(episode: Episode) -> rrb.Container:
    import rerun.blueprint as rrb

    from lfr.view.episode import observation_groups

    schema = episode.schema
    names = [
        n for key in (STATE, ENVIRONMENT_STATE) if key in schema for n in schema[key].names or ()
    ]
    groups = observation_groups(names)
    views = [series_view(group, f"/observation/{group}") for group in groups]
    return rrb.Grid(*views, series_view("joints (rad)", "/joints"), name="Observation")


def _about() -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.TextDocumentView(origin="/about", name="About")


def _panels(timeline: str) -> list[rrb.BlueprintPart]:
    import rerun.blueprint as rrb

    return [
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=timeline, loop_mode="All", play_state="Playing"),
    ]
