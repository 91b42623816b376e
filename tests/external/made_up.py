"""Two made-up arms in a plane, recorded by LeRobot itself: other names, units and dimensions.

Both go straight to a goal and close their hand there. ``crane`` is steered by velocities along x
and y in mm/s and observes in millimetres; ``puck`` is steered by speed and heading (as cosine and
sine) with its hand's command first, and observes in metres. The goals of a task lie in one
quadrant, so a task is a direction.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.datasets import LeRobotDataset

from tests import tiny_project

FPS, LENGTH, STEP = 10, 24, 0.05  # m in one control step at full speed
QUADRANTS = {"push it": (1, 1), "pull it": (-1, 1), "park it": (1, -1)}

CRANE: dict[str, Any] = {
    "observation.state": {
        "dtype": "float32", "shape": (3,), "names": {"motors": ["y_mm", "x_mm", "joint"]},
    },
    "observation.goal": {"dtype": "float32", "shape": (2,), "names": ["gx", "gy"]},
    "action": {"dtype": "float32", "shape": (3,), "names": ["vx", "vy", "hand"]},
}  # fmt: skip
PUCK: dict[str, Any] = {
    "observation.state": {"dtype": "float32", "shape": (4,), "names": None},
    "action": {"dtype": "float32", "shape": (4,), "names": None},
}

EXTERNAL = """
external:
  arms:
    crane:
      path: data/external/crane
      fps: 10
      robot_type: crane
      observation:
        - column: observation.state
          dims: [x_mm, y_mm]
          names: [hand_pos.x, hand_pos.y]
          unit: 1000
        - {column: observation.goal, names: [goal_pos.x, goal_pos.y], unit: 1000}
      action: {column: action, low: [-500, -500, 0], high: [500, 500, 1]}
      tasks:
        push: {instruction: push it}
        pull: {instruction: pull it}
        park: {instruction: park it}
    puck:
      fps: 10
      observation:
        - {column: observation.state, names: [hand_pos.x, hand_pos.y, goal_pos.x, goal_pos.y]}
      action: {column: action}
      tasks:
        push: {path: data/external/puck-push}
        pull: {path: data/external/puck-pull}
      environments:
        push:
          id: tests.external.plane:lfr-test/Plane-v0
          kwargs: {quadrant: [1, 1]}
          observation: {observation.state: agent_pos}
        park:
          id: tests.external.plane:lfr-test/Plane-v0
          observation: {observation.state: agent_pos}
  scenarios:
    plane: {common: [push, pull], arms: [crane, puck], new: {puck: park}}
  transfers: [plane-puck-park]
  learned: [plane-puck-park]
"""

SIZES = """
skills:
  vae: {horizon: 5, execute: 3, latent_dim: 6, hidden: 32, steps: 800, batch: 64}
  prior: {hidden: 64, layers: 3, steps: 800, batch: 64}
  held_out: 0.25
mapping:
  {hidden: 64, steps: 1500, batch: 64, posterior_share: 0.25, condition: state, hand: {weight: 9}}
"""


def params(text: str = EXTERNAL) -> str:
    """The tiny parameters with these arms and networks that can learn something."""
    tiny = tiny_project.ROOT.joinpath("tests/tiny_params.yaml").read_text()
    kept, skip = [], False
    for line in tiny.splitlines(keepends=True):
        if not line.startswith((" ", "#")):
            skip = line.split(":")[0] in ("external", "skills", "mapping")
        if not skip:
            kept.append(line)
    return "".join(kept) + SIZES + text


def write_both(folder: Path, episodes: int = 8) -> None:
    """The crane's three tasks in one dataset, two of the puck's in one each."""
    _write(folder / "crane", "crane", CRANE, list(QUADRANTS), episodes)
    for task in ("push", "pull"):
        _write(folder / f"puck-{task}", "puck", PUCK, [f"{task} it"], episodes)


def way(task: str, seed: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Hand (2,), goal (2,) and velocity (2,) of each step of a demonstration, in m and m/s."""
    rng = np.random.default_rng(seed)
    hand = rng.uniform(-0.1, 0.1, 2)
    goal = rng.uniform(0.4, 0.8, 2) * QUADRANTS[task]
    for _ in range(LENGTH):
        velocity = (goal - hand) * FPS
        velocity *= min(1.0, STEP * FPS / max(float(np.linalg.norm(velocity)), 1e-9))
        yield hand.copy(), goal, velocity
        hand += velocity / FPS


def _write(
    root: Path, robot: str, features: dict[str, Any], tasks: list[str], episodes: int
) -> None:
    dataset = LeRobotDataset.create(
        f"theirs/{root.name}", FPS, features, root=root, robot_type=robot, use_videos=False
    )
    frame = _crane if robot == "crane" else _puck
    for number in range(episodes * len(tasks)):
        task = tasks[number % len(tasks)]
        for hand, goal, velocity in way(task, number):
            closed = float(np.linalg.norm(goal - hand) < 0.02)
            values = {
                key: np.float32(one) for key, one in frame(hand, goal, velocity, closed).items()
            }
            dataset.add_frame({**values, "task": task})
        dataset.save_episode()
    dataset.finalize()


def _crane(
    hand: np.ndarray, goal: np.ndarray, velocity: np.ndarray, closed: float
) -> dict[str, list[float]]:
    x, y = 1000 * hand
    return {
        "observation.state": [y, x, float(np.hypot(x, y))],
        "observation.goal": list(1000 * goal),
        "action": [*(1000 * velocity), closed],
    }


def _puck(
    hand: np.ndarray, goal: np.ndarray, velocity: np.ndarray, closed: float
) -> dict[str, list[float]]:
    speed = float(np.linalg.norm(velocity))
    heading = velocity / max(speed, 1e-9)
    return {
        "observation.state": [*hand, *goal],
        "action": [2 * closed - 1, 2 * speed / (STEP * FPS) - 1, *heading],
    }
