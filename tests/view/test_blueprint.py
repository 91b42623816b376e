"""Layouts: every curve is seen whole, and recordings opened together keep their own."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from rerun.experimental import RrdReader

from lfr.view.blueprint import (
    EpisodeLayout,
    episode_blueprint,
    learning_blueprint,
    policy_blueprint,
)
from lfr.view.eye import Eye
from lfr.view.side_by_side_layout import Side, beside_blueprint

LAYOUT = EpisodeLayout(
    "an episode", ("agentview",), {"eef_pos": "eef_pos (m)"}, Eye(np.ones(3), np.zeros(3)),
    actions={"translation": "Action: translation", "rotation": "Action: rotation"}, gripper=True,
)  # fmt: skip


def views(part: rrb.Container | rrb.View) -> Iterator[rrb.View]:
    for inner in part.contents if isinstance(part, rrb.Container) else ():
        assert isinstance(inner, rrb.Container | rrb.View)
        yield from views(inner)
    if isinstance(part, rrb.View):
        yield part


@pytest.mark.parametrize(
    ("blueprint", "fewest"),
    [
        (learning_blueprint("a run"), 9),
        (episode_blueprint(LAYOUT), 6),
        (policy_blueprint(LAYOUT, 3, ((0.0, 1.0), (0.0, 1.0))), 11),
    ],
)
def test_every_curve_is_seen_whole(blueprint: rrb.Blueprint, fewest: int) -> None:
    curves = [v for v in views(blueprint.root_container) if isinstance(v, rrb.TimeSeriesView)]
    assert len(curves) == fewest
    whole = rr.TimeRange(rr.TimeRangeBoundary.infinite(), rr.TimeRangeBoundary.infinite())
    expected = rrb.archetypes.TimeAxis(view_range=whole)
    for view in curves:
        assert view.properties["TimeAxis"].view_range == expected.view_range, view.name


@pytest.mark.parametrize("cameras", [(), ("agentview",), ("agentview", "wrist", "sideview")])
def test_every_camera_has_a_view(cameras: tuple[str, ...]) -> None:
    shown = views(episode_blueprint(replace(LAYOUT, cameras=cameras)).root_container)
    pictures = [view for view in shown if isinstance(view, rrb.Spatial2DView)]
    assert [view.origin for view in pictures] == [f"/camera/{camera}" for camera in cameras]
    side = Side("/left", "an arm", cameras, Eye(np.ones(3), np.zeros(3)))
    other = replace(side, root="/right", cameras=("agentview",))
    both = views(beside_blueprint(side, other).root_container)
    origins = [view.origin for view in both if isinstance(view, rrb.Spatial2DView)]
    assert origins == [*(f"/left/camera/{camera}" for camera in cameras), "/right/camera/agentview"]


def test_a_recording_shares_its_layout_with_no_other(shown: Path, tmp_path: Path) -> None:
    from lfr.view.curve import save_learning

    curve = tmp_path / "learning.rrd"
    save_learning(curve, [{"env_steps": 0, "success": 0.5}], "a run")
    applications = set()
    for path in (shown, curve):
        reader = RrdReader(path)
        (recording,), (blueprint,) = reader.recordings(), reader.blueprints()
        assert recording.application_id == blueprint.application_id
        applications.add(recording.application_id)
    assert len(applications) == 2
