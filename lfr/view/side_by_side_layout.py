"""The layout of two episodes side by side: a half for each, and their rewards in one view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lfr.view.blueprint import BACKGROUND, UNIT, gripper_view, pictures_view, series_view
from lfr.view.eye import Eye

if TYPE_CHECKING:
    import rerun.blueprint as rrb


@dataclass(frozen=True)
class Side:
    """One half.

    Attributes:
        root: the entity that everything of it stands below.
        title: of the episode.
        cameras: names of its cameras.
        eye: of its 3-D view.
        actions: of a known embodiment's action the quantities, the gripper aside.
        series: entities to plot below `root` where the action is another.
    """

    root: str
    title: str
    cameras: tuple[str, ...]
    eye: Eye
    actions: tuple[str, ...] = ()
    series: tuple[str, ...] = ()


def beside_blueprint(left: Side, right: Side) -> rrb.Blueprint:
    """Both arms above; gripper and success, the rewards and the actions below."""
    import rerun.blueprint as rrb

    sides = (left, right)
    rewards = series_view("Reward", [f"{side.root}/reward" for side in sides])
    overview = rrb.Vertical(
        rrb.Horizontal(*map(_arm, sides)),
        rrb.Horizontal(*map(_states, sides)),
        rewards,
        row_shares=[3.4, 1, 0.9],
        name="Side by side",
    )
    actions = rrb.Horizontal(*map(_actions, sides), name="Actions and gripper")
    cameras = [pictures_view(_cameras(side)) for side in sides if side.cameras]
    tabs = [overview, actions]
    if cameras:
        tabs.append(rrb.Horizontal(*cameras, name="Cameras"))
    about = [rrb.TextDocumentView(origin=f"{side.root}/about", name=side.title) for side in sides]
    tabs.append(rrb.Horizontal(*about, name="About"))
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="time", loop_mode="All", play_state="Playing"),
    )


def _arm(side: Side) -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.Spatial3DView(
        origin=f"{side.root}/world",
        contents=[f"{side.root}/{part}/**" for part in ("world", "path", "frustum")],
        name=side.title,
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
        eye_controls=rrb.EyeControls3D(
            kind="Orbital", position=side.eye.position, look_target=side.eye.target
        ),
    )


def _cameras(side: Side) -> list[rrb.View]:
    import rerun.blueprint as rrb

    return [
        rrb.Spatial2DView(origin=f"{side.root}/camera/{camera}", name=f"{side.title}: {camera}")
        for camera in side.cameras
    ]


def _states(side: Side) -> rrb.View:
    import rerun.blueprint as rrb

    return rrb.StateTimelineView(origin=f"{side.root}/state", name="Gripper and success")


def _actions(side: Side) -> rrb.Container:
    import rerun.blueprint as rrb

    if side.series:
        views = [series_view(entity, f"{side.root}/{entity}") for entity in side.series]
        return rrb.Vertical(*views, name=side.title)
    return rrb.Vertical(
        *(
            series_view(f"Action: {name}", f"{side.root}/action/{name}", UNIT)
            for name in side.actions
        ),
        gripper_view(side.root),
        series_view("End effector (m)", f"{side.root}/observation/eef_pos"),
        name=side.title,
    )
