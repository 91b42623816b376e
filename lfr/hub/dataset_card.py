"""A dataset's card: what was recorded and how, every dimension, how to load it and rebuild it."""

from __future__ import annotations

from huggingface_hub import DatasetCardData

from lfr.data.episode import IMAGES
from lfr.data.tables import VERSION
from lfr.embodiments import embodiment, is_known
from lfr.hub.dataset_columns import dimension_tables, feature_table
from lfr.hub.dataset_facts import Column, DatasetFacts, Making
from lfr.hub.departures import departures
from lfr.hub.markdown import card, python, shell, table
from lfr.seeds import FIRST, PER_USE, use_of_seed
from lfr.tasks import TASKS

LICENSE = "apache-2.0"
SIZES = ((10**3, "n<1K"), (10**4, "1K<n<10K"), (10**5, "10K<n<100K"), (10**6, "100K<n<1M"),
         (10**7, "1M<n<10M"), (10**8, "10M<n<100M"), (10**9, "100M<n<1B"))  # fmt: skip


def dataset_card(
    facts: DatasetFacts,
    making: Making | None = None,
    *,
    repo_id: str | None = None,
    picture: str | None = None,
    logs: bool = False,
    license: str | None = None,
) -> str:
    """The card of a dataset, as Markdown with a YAML header.

    Args:
        facts: of the dataset.
        making: how it was made, if this project's stages made it.
        repo_id: where it is published; None is the folder in this project.
        picture: name of the picture's file beside the card.
        logs: whether the MCAP logs are published beside the data.
        license: None is this project's for what its stages made; of the data of others nothing is
            known, and the card names none.
    """
    limits = _limits(facts, making)
    shown = f"![Episode 0 of {facts.name}, first frame to last]({picture})" if picture else ""
    return card(
        _header(facts, making, license),
        f"# {facts.name}",
        _summary(facts, making),
        shown,
        "## What was recorded and how",
        _counts(facts, making),
        _how(facts, making, logs),
        "## Features",
        feature_table(facts),
        *(
            part
            for column in facts.columns
            for part in dimension_tables(column, facts.space(column))
        ),
        _episodes(facts, making),
        "## Load",
        _load(facts, repo_id),
        "## Rebuild" if making else "",
        _rebuild(facts, making),
        "## Known limits" if limits else "",
        limits,
    )


def _header(facts: DatasetFacts, making: Making | None, license: str | None) -> DatasetCardData:
    size = next((name for bound, name in SIZES if facts.frames < bound), "1B<n<10B")
    made = ("simulation", "robosuite") if making else ()
    return DatasetCardData(
        license=license or (LICENSE if making else None),
        pretty_name=facts.name,
        task_categories=["robotics"],
        size_categories=[size],
        tags=[t for t in ("LeRobot", "robotics", *made, facts.robot, *facts.tasks) if t],
        configs=[{"config_name": "default", "data_files": "data/*/*.parquet"}],
    )


def _summary(facts: DatasetFacts, making: Making | None) -> str:
    words = "; ".join(f"*{each}*" for each in facts.instructions)
    many = len(facts.instructions)
    tasks = f"one task, {words}" if many == 1 else f"{many} tasks, {words}"
    known = is_known(facts.robot)
    arm = embodiment(facts.robot).robot.title if known else facts.robot
    by = f", by the arm {arm}" if arm else ""
    scenes = ", ".join(TASKS[task].stock_name for task in facts.tasks if task in TASKS)
    scene = f", in simulation ({scenes})" if _ours(facts, making) else ""
    return (
        f"{facts.episodes} episodes of {tasks}{by}{scene}. "
        f"[LeRobot](https://github.com/huggingface/lerobot) {VERSION}, {facts.fps} frames a second."
    )


def _counts(facts: DatasetFacts, making: Making | None) -> str:
    shortest, median, longest = facts.lengths
    named = {"robot": facts.robot, "task": "`, `".join(facts.tasks)}
    known = {what: f"`{name}`" for what, name in named.items() if name}
    rows: list[tuple[str, str]] = [
        *([(", ".join(known), ", ".join(known.values()))] if known else []),
        ("episodes", str(facts.episodes)),
        ("frames", f"{facts.frames}, at {facts.fps} per second"),
        ("frames of an episode", f"{shortest} to {longest}, median {median:g}"),
        ("size", f"{facts.size / 1e6:.1f} MB"),
    ]
    if facts.successes is not None:
        rows.append(("successful episodes", f"{facts.successes} of {facts.episodes}"))
    if facts.seeds is not None:
        use = use_of_seed(facts.seeds[0]) if making else None
        rows.append(("seeds", f"{facts.seeds[0]} to {facts.seeds[1]}{_range(use)}"))
    if making:
        attempts, failures = making.record["attempts"], making.record["failures"]
        rate = making.record["expert_success"]
        rows += [
            ("attempts of the demonstrator", f"{attempts}, of which {failures} failed"),
            ("success rate of the demonstrator", f"{100 * rate:.1f} %"),
            ("controller", f"`{embodiment(facts.robot).controller.stock_name}`, {facts.fps} Hz"),
        ]
    for camera in facts.cameras:
        name = camera.key.removeprefix(IMAGES)
        said = filter(None, (_pixels(camera), camera.codec.upper()))
        rows.append((f"camera `{name}`", ", ".join(said)))
    return table(("", ""), rows)


def _pixels(camera: Column) -> str:
    sides = dict(zip(camera.names, camera.shape, strict=False))  # some have the channels first
    height, width = camera.shape[:2]
    return f"{sides.get('width', width)} x {sides.get('height', height)} pixels"


def _range(use: str | None) -> str:
    """Where seeds of this use lie, and that no other use's lie there."""
    if use is None:
        return ""
    first = FIRST[use]  # pyright: ignore[reportArgumentType]
    return f", of the range {first} to {first + PER_USE - 1} for {use}s only"


def _how(facts: DatasetFacts, making: Making | None, logs: bool) -> str:
    lines = []
    if making:
        versions = making.record["provenance"]["packages"]
        lines += [
            "The scene, reward and success check are those of robosuite "
            f"{versions['robosuite']}, stepped by MuJoCo {versions['mujoco']} in a compiled kernel "
            "that tests hold to robosuite's own loop. A scripted expert leads the hand from "
            "waypoint to waypoint. What the arm executes is its action with noise and a rare push "
            "or slip; `action` is the clean one, which a learner should do in that state. Before "
            "the first frame the hand drifts, so that demonstrations start in many places.",
            "Frame t holds what was observed before action t, action t, and, as `next.*`, what "
            "came of it. The robot's base frame has the axes and the origin of the body "
            f"`{embodiment(facts.robot).robot.base_body}`.",
        ]
        if making.record["failed_seeds"]:
            failed = ", ".join(str(seed) for seed in making.record["failed_seeds"])
            lines.append(f"Only successful attempts are kept. Seeds that failed: {failed}.")
    if logs:
        lines.append(
            "`logs/` holds each episode's MCAP log, which Foxglove and rerun open as it is: the "
            "executed actions, simulator states that replay the episode, poses of all bodies."
        )
    return "\n\n".join(lines)


def _episodes(facts: DatasetFacts, making: Making | None) -> str:
    said = []
    if facts.noted:
        *some, last = (f"`{name}`" for name in facts.noted)
        named = f"{', '.join(some)} and {last}" if some else last
        said.append(
            f"Each row of `meta/episodes` has, beside LeRobot's columns, {named}; "
            "read them with pandas or pyarrow."
        )
    if making:
        said.append(
            "`meta/stats.json` and each episode's statistics hold minimum, maximum, mean, standard "
            "deviation and the quantiles 1, 10, 50, 90 and 99 %, taken over all values at once."
        )
    return " ".join(said)


def _load(facts: DatasetFacts, repo_id: str | None) -> str:
    place = f'"{repo_id}"' if repo_id else f'"lfr/{facts.name}", root="data/lerobot/{facts.name}"'
    key = next((c.key for c in facts.columns if len(c.names) > 1 and c.dtype != "video"), "index")
    return python(
        "from lerobot.datasets import LeRobotDataset",
        f'dataset = LeRobotDataset({place}, video_backend="pyav")',
        f'print(len(dataset), dataset[0]["{key}"], dataset[0]["task"])',
    )


def _rebuild(facts: DatasetFacts, making: Making | None) -> str:
    if not making:
        return ""
    recorded, packed = (_revision(stage["provenance"]) for stage in (making.record, making.pack))
    commands = shell(
        f"git checkout {making.record['provenance']['revision']}",
        "make setup",
        f".venv/bin/dvc repro pack@{facts.name}",
    )
    return (
        f"Recorded by revision {recorded} of lfr, packed by {packed}. In a checkout of lfr:\n\n"
        f"{commands}\n\nThe same seed gives the same episode; `params.yaml` has the parameters."
    )


def _revision(provenance: dict) -> str:
    changed = " with uncommitted changes" if provenance["modified"] else ""
    return f"`{provenance['revision']}`{changed}"


def _limits(facts: DatasetFacts, making: Making | None) -> str:
    lines = []
    if making:
        lines += [
            "Simulated: no real robot has moved, and nothing here is measured on one.",
            "The demonstrator is a script that reads the objects' true poses. "
            "Its failed attempts are left out.",
            "`action` is not what the arm executed. To replay an episode, take `/executed_action` "
            "from its log.",
        ]
    arm = embodiment(facts.robot).robot if _ours(facts, making) else None
    lines += departures(arm) if arm else []
    if making and facts.cameras:
        lines.append("Pictures are small and meant for people; no model of lfr has seen them.")
    if facts.robot and len(facts.instructions) == 1:
        lines.append("One arm and one task: it says nothing of others.")
    return "\n".join(f"- {line}" for line in lines)


def _ours(facts: DatasetFacts, making: Making | None) -> bool:
    return making is not None and is_known(facts.robot) and set(facts.tasks) <= set(TASKS)
