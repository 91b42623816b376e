"""The README's moving picture: `python -m pipeline._moving` after the main job.

At its left the source, which was shown the task; at its right the target, which was not, as it does
it after learning; both from the same held-out start. It goes to docs/pictures/transfer.gif.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lfr.artifacts import write_whole
from lfr.evaluation.names import NAMES
from lfr.policies import Array, Policy, run_episode
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.seeds import episode_seed
from lfr.sim.camera import Camera
from lfr.sim.simulation import Simulation, simulation
from lfr.sim.steps import Steps
from lfr.skills.library import pipeline_models
from lfr.skills.skill_policy import SkillFiles
from lfr.transfer.model import LearnedFiles

OUT = Path("docs/pictures/transfer.gif")
SIZE, GAP = 360, 8  # pixels of an arm's picture, and between the two
EVERY, RATE = 2, 20  # control steps to a picture, and to a second
LINGER = 16  # control steps after success
HOLD = 1200  # ms that the end stands


class Watched:
    """A simulation, with a picture at every so many control steps.

    Attributes:
        pictures: (SIZE, SIZE, 3) uint8.
    """

    def __init__(self, simulated: Simulation) -> None:
        self.simulation, self.horizon = simulated, simulated.horizon
        name, task = simulated.embodiment.name, simulated.task.name
        self._camera = Camera(name, task, "frontview", SIZE, SIZE)

    def reset(self, seed: int) -> Array:
        observation = self.simulation.reset(seed)
        self.pictures: list[NDArray[np.uint8]] = [self._camera.render(self.simulation)]
        self._step = 0
        return observation

    def step(self, actions: Array, stop_on_success: bool = False) -> Steps:
        steps = []
        for action in actions:
            steps.append(self.simulation.step(action[None]))
            self._step += 1
            if self._step % EVERY == 0:
                self.pictures.append(self._camera.render(self.simulation))
            if stop_on_success and steps[-1].successes[0]:
                break
        return Steps(
            np.concatenate([one.observations for one in steps]),
            np.concatenate([one.rewards for one in steps]),
            np.concatenate([one.successes for one in steps]),
            steps[-1].diverged,
        )


def main(transfer: str = "s2-sawyer-joint_position-pick_place", start: str = "0") -> None:
    """Draw a transfer of the main job from one of its held-out starts."""
    chosen = transfer_named(transfer)
    source = pipeline_models(scenario_named(chosen.scenario), chosen)["source"]
    shown = SkillFiles(str(source.prior(chosen.task)), str(source.vae())).load(chosen.source)
    learned = LearnedFiles(f"models/transfer/{transfer}-lfr/seed-0").load(chosen.target)
    seed = episode_seed("held-out", int(start))
    task = NAMES[chosen.task]
    rows = [
        _watched(shown, chosen.source, chosen.task, seed, f"was shown {task}"),
        _watched(learned, chosen.target, chosen.task, seed, f"was never shown {task}"),
    ]
    frames = _side_by_side(rows)
    with write_whole(OUT) as partial:
        frames[0].save(
            partial, format="GIF", save_all=True, append_images=frames[1:], loop=0, optimize=True,
            duration=[1000 * EVERY // RATE] * (len(frames) - 1) + [HOLD],
        )  # fmt: skip


def _watched(policy: Policy, robot: str, task: str, seed: int, words: str) -> list[Image.Image]:
    watched = Watched(simulation(robot, task))
    outcome = run_episode(policy, watched, seed, linger=LINGER)
    print(f"{robot}: {'success' if outcome.success else 'failure'} after {outcome.steps} steps")
    arm = NAMES[robot.partition("-")[0]]
    return [_labelled(Image.fromarray(one), f"{arm} {words}") for one in watched.pictures]


def _labelled(picture: Image.Image, words: str) -> Image.Image:
    draw = ImageDraw.Draw(picture)
    font = ImageFont.load_default(size=18)
    draw.rectangle((0, 0, SIZE, 30), fill=(255, 255, 255))
    draw.text((SIZE // 2, 15), words, fill=(20, 20, 20), font=font, anchor="mm")
    return picture


def _side_by_side(rows: Sequence[Sequence[Image.Image]]) -> list[Image.Image]:
    """Frames in few colours, which both share; the one that is done first waits."""
    count = max(map(len, rows))
    frames = []
    for index in range(count):
        frame = Image.new("RGB", (2 * SIZE + GAP, SIZE), "white")
        for place, row in enumerate(rows):
            frame.paste(row[min(index, len(row) - 1)], (place * (SIZE + GAP), 0))
        frames.append(frame)
    palette = frames[count // 2].quantize(96, dither=Image.Dither.NONE)
    return [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]


if __name__ == "__main__":
    sys.exit(run_stage(main))
