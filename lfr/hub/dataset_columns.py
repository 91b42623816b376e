"""A card's tables of a dataset's features, and of the dimensions of each."""

from __future__ import annotations

from lfr.data.episode import ACTION, FEATURES
from lfr.embodiments import embodiment, is_known
from lfr.hub.dataset_facts import Column, DatasetFacts
from lfr.hub.dimensions import rows
from lfr.hub.markdown import table
from lfr.spaces import Space

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
        if is_known(facts.robot):
            body = embodiment(facts.robot)
            about[ACTION] = body.controller.about(body.robot)
    features = []
    for column in facts.columns:
        said = about.get(column.key, "")
        if column.dtype == "video":
            said = " x ".join(column.names)
            said = f"RGB picture before the action; {said}" if facts.our_layout else said
        features.append((f"`{column.key}`", column.dtype, _shape(column), said))
    return table(("feature", "type", "shape", "content"), features)


def dimension_tables(column: Column, space: Space | None) -> list[str]:
    """A heading and the table of a vector's dimensions; nothing for scalars and videos.

    Args:
        space: what the dimensions are; None where nothing is known of them but their names.
    """
    if column.dtype == "video" or len(column.names) < 2:
        return []
    if space is None:
        named = ", ".join(f"`{name}`" for name in column.names)
        return [f"### {column.key}", f"In this order: {named}."]
    unit = "a unit of it is" if column.key == ACTION else "unit"
    return [f"### {column.key}", table(("dimensions", unit, "frame", "meaning"), rows(space))]


def _shape(column: Column) -> str:
    return " x ".join(str(side) for side in column.shape)
