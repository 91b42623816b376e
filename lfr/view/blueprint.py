"""How each kind of recording is laid out: 3-D large at the left, camera and series at the right.

Layouts are given titles, names and sizes. They know the entities that the recordings write to (each
such module lists its own), and none of the code that writes them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from lfr.view.eye import Eye

if TYPE_CHECKING:
    import rerun.blueprint as rrb

BACKGROUND = (22, 25, 31)
FINDINGS, FINDINGS_LIST = "/findings", "/findings/list"
UNIT = (-1.05, 1.05)
"""What is shown of an action in [-1, 1]."""
ACROSS = 2  # pictures of cameras in a row


@dataclass(frozen=True)
class EpisodeLayout:
    """What the layout of an episode depends on.

    Attributes:
        title: of the episode.
        cameras: names of its cameras.
        groups: of its observation, each an entity below `/observation`: name -> title.
        eye: of the 3-D view; None where there is nothing to see in it.
        actions: of its action, likewise below `/action`.
        gripper: whether the action is a known one, in [-1, 1], with a gripper of its own.
        absent: which of `/state`, `/reward` and `/joints` the episode does not have.
        findings: whether what is found of it is shown.
    """

    title: str
    cameras: tuple[str, ...]
    groups: Mapping[str, str]
    eye: Eye | None
    actions: Mapping[str, str] = field(default_factory=dict)
    gripper: bool = False
    absent: frozenset[str] = frozenset()
    findings: bool = False


def episode_blueprint(layout: EpisodeLayout) -> rrb.Blueprint:
    """Arm and path at the left; camera, success, action, gripper and reward at the right."""
    import rerun.blueprint as rrb

    return rrb.Blueprint(
        rrb.Tabs(_episode_tab(layout), _observation_tab(layout), _about_tab(), active_tab=0),
        *_panels("time"),
    )


def policy_blueprint(
    layout: EpisodeLayout,
    latent_dim: int,
    latent_bounds: tuple[tuple[float, float], tuple[float, float]],
) -> rrb.Blueprint:
    """Arm at the left; the latents of the present skill, divergence and success at the right.

    Args:
        layout: of the episode.
        latent_dim: dimensions of the latent space.
        latent_bounds: what the panels of the latent spaces show, horizontally and vertically.
    """
    import rerun.blueprint as rrb

    right = rrb.Vertical(
        _latent_view("target", "Target's latent space: mapped prior, policy, z", latent_bounds),
        _latent_view("source", "Source's latent space: its prior", latent_bounds),
        series_view("KL of policy from mapped prior (nats)", "/skill/divergence", legend=False),
        series_view("Mean sigma of each distribution", "/skill/spread"),
        _state_view(),
        row_shares=[2.2, 2.2, 1, 1.1, 1.3],
    )
    overview = rrb.Horizontal(
        arm_view(layout.title, layout.eye), right, column_shares=[1.5, 1], name="Policy"
    )
    dimensions = [
        series_view(f"z{d}", f"/skill/dimension/{d}", legend=d == 0) for d in range(latent_dim)
    ]
    skills = rrb.Grid(*dimensions, name="Latent dimensions")
    tabs = rrb.Tabs(
        overview, skills, _episode_tab(layout), _observation_tab(layout), _about_tab(), active_tab=0
    )
    return rrb.Blueprint(tabs, *_panels("time", choice=True))


def learning_blueprint(title: str, *, choice: bool = False) -> rrb.Blueprint:
    """Success large, return and length beside it, what is known of the updates below.

    Args:
        title: of the run.
        choice: show the list of recordings; a run leaves episodes beside its curves.
    """
    import rerun.blueprint as rrb

    first = rrb.Horizontal(
        series_view(
            "Success rate",
            ["/evaluation/success/**", "/learning/success/**"],
            (-0.02, 1.02),
            corner="RightBottom",
        ),
        rrb.Vertical(
            series_view("Return of an episode", "/evaluation/return/**", legend=False),
            series_view("Episode length (control steps)", "/evaluation/length/**", legend=False),
        ),
        column_shares=[2, 1],
    )
    updates = rrb.Grid(
        series_view("KL of policy from mapped prior (nats)", "/update/kl/**", legend=False),
        series_view("Temperature alpha", "/update/alpha/**", legend=False),
        series_view("Mean sigma of the policy", "/update/sigma/**", legend=False),
        series_view("Q", "/update/q/**", legend=False),
        series_view("Critic's loss", "/update/critic_loss/**", legend=False),
        series_view("Policy's loss", "/update/policy_loss/**", legend=False),
        grid_columns=3,
    )
    named = rrb.Vertical(first, updates, name=f"{title}, against environment steps")
    return rrb.Blueprint(rrb.Tabs(named), *_panels("env_steps", moving=False, choice=choice))


def arm_view(name: str, eye: Eye | None) -> rrb.Spatial3DView:
    """The arm, its task and its path in 3-D."""
    import rerun.blueprint as rrb

    return rrb.Spatial3DView(
        origin="/",
        contents=["/world/**", "/path/**", "/frustum/**"],
        name=name,
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
        line_grid=rrb.LineGrid3D(
            visible=True, spacing=0.5, stroke_width=0.6, color=(70, 76, 88, 110)
        ),
        eye_controls=None
        if eye is None
        else rrb.EyeControls3D(kind="Orbital", position=eye.position, look_target=eye.target),
    )


def series_view(
    name: str,
    contents: str | Sequence[str],
    span: tuple[float, float] | None = None,
    *,
    legend: bool = True,
    corner: Literal["RightTop", "RightBottom"] = "RightTop",
) -> rrb.TimeSeriesView:
    """Curves over the whole of their timeline; `span` fixes the vertical axis."""
    import rerun as rr
    import rerun.blueprint as rrb

    # Left to itself, rerun shows a stretch around the cursor where a timeline counts steps.
    whole = rr.TimeRange(rr.TimeRangeBoundary.infinite(), rr.TimeRangeBoundary.infinite())
    return rrb.TimeSeriesView(
        origin="/",
        contents=[contents] if isinstance(contents, str) else list(contents),
        name=name,
        axis_x=rrb.archetypes.TimeAxis(view_range=whole),
        axis_y=rrb.ScalarAxis(range=span) if span else None,
        plot_legend=rrb.PlotLegend(corner=corner, visible=legend),
    )


def _episode_tab(layout: EpisodeLayout) -> rrb.Container:
    """What moves, in 3-D or as the cameras see it, at the left; at the right what goes with it."""
    import rerun.blueprint as rrb

    cameras: list[rrb.View] = [
        rrb.Spatial2DView(origin=f"/camera/{camera}", name=camera) for camera in layout.cameras
    ]
    series: list[tuple[rrb.View | rrb.Container, float]] = [(view, 1) for view in _actions(layout)]
    if "/state" not in layout.absent:
        series.insert(0, (_state_view(), 1.35))
    if "/reward" not in layout.absent:
        series.append((series_view("Reward", "/reward", legend=False), 1))
    if layout.eye is not None and cameras:
        rows = -(-len(cameras) // ACROSS)
        series.insert(0, (pictures_view(cameras), 2.2 * rows))
    right = rrb.Vertical(*(view for view, _ in series), row_shares=[share for _, share in series])
    if layout.eye is not None:
        left: rrb.View | rrb.Container = arm_view(layout.title, layout.eye)
    elif cameras:
        left = rrb.Grid(*cameras)
    elif layout.findings:
        return rrb.Horizontal(_findings_view(), right, name="Episode")
    else:
        return rrb.Horizontal(right, name="Episode")
    if layout.findings:
        left = rrb.Vertical(left, _findings_view(), row_shares=[1.7, 1])
    return rrb.Horizontal(left, right, column_shares=[1.7, 1], name="Episode")


def _findings_view() -> rrb.Container:
    """The findings in the order of time, where a click leads to each, above all there is to say."""
    import rerun.blueprint as rrb

    log = rrb.TextLogView(
        origin=FINDINGS,
        contents=[FINDINGS],
        name="Findings: a click on a time leads there",
        columns=rrb.TextLogColumns(
            timeline_columns=["time"], text_log_columns=["loglevel", "body"]
        ),
    )
    return rrb.Tabs(log, rrb.TextDocumentView(origin=FINDINGS_LIST, name="All that is said"))


def pictures_view(cameras: Sequence[rrb.View]) -> rrb.View | rrb.Container:
    """One camera's pictures, or those of several in rows of two."""
    import rerun.blueprint as rrb

    if len(cameras) == 1:
        return cameras[0]
    return rrb.Grid(*cameras, grid_columns=ACROSS)


def _actions(layout: EpisodeLayout) -> list[rrb.View]:
    span = UNIT if layout.gripper else None
    actions = layout.actions.items()  # and what a policy would have done, where it is there
    views = [series_view(title, f"/action/{name}/**", span) for name, title in actions]
    return [*views, *((gripper_view(),) if layout.gripper else ())]


def gripper_view(root: str = "") -> rrb.View:
    """What the gripper is told, what it has become of that, and its aperture."""
    contents = [f"{root}/action/gripper/**", f"{root}/gripper"]
    return series_view("Gripper (-1 open, +1 closed)", contents, UNIT)


def _state_view() -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.StateTimelineView(origin="/state", name="Gripper and success")


def _latent_view(
    space: str, name: str, bounds: tuple[tuple[float, float], tuple[float, float]]
) -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.Spatial2DView(
        origin=f"/latent/{space}",
        name=name,
        visual_bounds=rrb.VisualBounds2D(x_range=bounds[0], y_range=bounds[1]),
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
    )


def _observation_tab(layout: EpisodeLayout) -> rrb.Container:
    import rerun.blueprint as rrb

    views = [series_view(title, f"/observation/{group}") for group, title in layout.groups.items()]
    if "/joints" not in layout.absent:
        views.append(series_view("joints (rad)", "/joints"))
    return rrb.Grid(*views, name="Observation")


def _about_tab() -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.TextDocumentView(origin="/about", name="About")


def _panels(timeline: str, *, moving: bool = True, choice: bool = False) -> list[rrb.BlueprintPart]:
    """The panels around the views; `choice` opens the one with the list of recordings."""
    import rerun.blueprint as rrb

    return [
        rrb.BlueprintPanel(state="expanded" if choice else "collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(
            state="collapsed",
            timeline=timeline,
            loop_mode="All" if moving else "Off",
            play_state="Playing" if moving else "Following",
        ),
    ]
