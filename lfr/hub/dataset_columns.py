"""A card's tables of a dataset's features, and of the dimensions of each."""

from __future__ import annotations

from lfr.data.episode import ACTION, FEATURES, JOINT_POSITION
from lfr.hub.dataset_facts import Column, DatasetFacts
from lfr.hub.dimensions import groups
from lfr.hub.markdown import table

LEROBOT = {
    "timestamp": "s from the episode's start",
    "frame_index": "frame of the episode, from 0",
    "episode_index": "number of the episode",
    "index": "row of the dataset",
    "task_index": "row of meta/tasks.parquet",
}


def feature_table(facts: DatasetFacts) -> str:
    """Every feature: its type and shape, and its content where that is known."""
    about = LEROBOT
    if facts.our_layout:
        about = {feature.key: feature.about for feature in FEATURES} | LEROBOT
    rows = []
    for column in facts.columns:
        said = about.get(column.key, "")
        if column.dtype == "video":
            said = " x ".join(column.names)
            said = f"RGB picture before the action; {said}" if facts.our_layout else said
        rows.append((f"`{column.key}`", column.dtype, _shape(column), said))
    return table(("feature", "type", "shape", "content"), rows)


def dimension_tables(column: Column, our_layout: bool) -> list[str]:
    """A heading and the table of a vector's dimensions; nothing for scalars and videos.

    Units and frames are given where the layout is this project's: with others, `gripper` may be
    degrees.
    """
    if column.dtype == "video" or len(column.names) < 2:
        return []
    if not our_layout:
        named = ", ".join(f"`{name}`" for name in column.names)
        return [f"### {column.key}", f"In this order: {named}."]
    if column.key == JOINT_POSITION:
        shown = f"`{column.names[0]}` to `{column.names[-1]}`"
        rows = [(shown, "rad", "", "angles of the joints of these names")]
    else:
        rows = [
            (f"`{shown}`", *((known.unit, known.frame, known.about) if known else ("", "", "")))
            for shown, known in groups(column.names)
        ]
    unit = "a unit of it is" if column.key == ACTION else "unit"
    return [f"### {column.key}", table(("dimensions", unit, "frame", "meaning"), rows)]


def _shape(column: Column) -> str:
    return " x ".join(str(side) for side in column.shape)
