"""Training on a CUDA device against one core of the processor beside it: when it pays.

    python -m benchmarks.devices [--repeats 5] [--out results/benchmarks]

Each part of the training runs as a job does, with the parameters of params.yaml and on made-up
rows, for a few hundred steps on either side. The rows below the first of each part ask at what size
the device would pay: with sixteen times the batch, or networks four times as wide. A ratio below 1
says that one core is faster. Without a CUDA device nothing is measured and nothing written.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from benchmarks._figures import FOLDER, Figure, Measurement, compare, show, write
from lfr.embodiments import embodiment
from lfr.mapping.generator import Generator
from lfr.mapping.mapping_params import MappingParams
from lfr.mapping.mapping_training import Pairs, train_mapping
from lfr.networks.device import device_named
from lfr.skills.prior import SkillPrior
from lfr.skills.skill_params import PriorParams, SkillsParams, VAEParams
from lfr.skills.skill_training import PriorMaterial, train_priors, train_vae
from lfr.skills.symmetry import AS_RECORDED
from lfr.skills.vae import SkillVAE
from lfr.tasks import task
from lfr.transfer.learner import Learner
from lfr.transfer.methods.initialization import initialize_from
from lfr.transfer.replay import Batch
from lfr.transfer.transfer_params import TransferParams

ROWS, TASKS = 5_000, ("lift", "nut_assembly", "stack")
ACTION = embodiment("panda").action.names
LAYOUT = task("nut_assembly").observation.names
MANY, WIDE = 16, 4
STEPS, FEWER = 240, 48  # timed at a time

Trained = Callable[[str], object]
"""Trains for a number of steps on the device of that name."""


def vae(params: VAEParams) -> Trained:
    actions = 2.0 * torch.rand(ROWS, params.horizon, len(ACTION)) - 1.0
    return lambda name: train_vae(actions, ACTION, params, 0, _device(name))


def priors(skills: SkillsParams, params: PriorParams) -> Trained:
    latent = SkillVAE(skills.vae.horizon, len(ACTION), skills.vae.latent_dim, skills.vae.hidden)
    actions = 2.0 * torch.rand(ROWS, skills.vae.horizon, len(ACTION)) - 1.0
    params = replace(params, symmetry=AS_RECORDED)
    materials = []
    for seed, one in enumerate(TASKS):
        names = task(one).observation.names
        seen = 0.2 * torch.randn(ROWS, len(names))
        materials.append(PriorMaterial(seen, actions, names, ACTION, seed))
    return lambda name: train_priors(latent, materials, params, _device(name))


def mapping(skills: SkillsParams, params: MappingParams) -> Trained:
    pairs = Pairs(*torch.randn(2, ROWS, 2 * skills.vae.latent_dim))
    return lambda name: train_mapping(pairs, replace(params, device=name), 0)


def learner(
    skills: SkillsParams, mapped: MappingParams, params: TransferParams, steps: int
) -> Trained:
    latent, rows = skills.vae.latent_dim, params.batch * 12  # twelve updates a round, as by default

    def run(name: str) -> None:
        prior = SkillPrior(LAYOUT, latent, skills.prior.hidden, skills.prior.layers)
        phi = Generator(latent, mapped.hidden, mapped.layers)
        decoder = SkillVAE(skills.vae.horizon, len(ACTION), latent, skills.vae.hidden)
        begun = initialize_from(prior, phi, decoder, params, prior)
        one = Learner(
            begun.actor.policy, begun.normalizer, len(LAYOUT), latent, params,
            torch.Generator().manual_seed(0), device=_device(name),
        )  # fmt: skip
        seen, after = torch.randn(2, rows, len(LAYOUT))
        of_z = torch.randn(5, rows, latent)
        batch = Batch(seen, of_z[0], torch.rand(rows), torch.full((rows,), 0.99), after, *of_z[1:])
        for _ in range(steps // 12):
            one.update(batch, 12)

    return run


def _many(params: Any) -> tuple[str, dict[str, Any]]:
    return f"/batch_x{MANY}", {"batch": MANY * params.batch}


def _wide(params: Any) -> tuple[str, dict[str, Any]]:
    return f"/hidden_x{WIDE}", {"hidden": WIDE * params.hidden}


def _device(name: str) -> torch.device:
    return device_named("cuda" if name == "cuda" else "cpu")


def _rate(trained: Trained, name: str, steps: int) -> Measurement:
    def measure() -> float:
        began = time.perf_counter()
        trained(name)
        if name == "cuda":
            torch.cuda.synchronize()
        return steps / (time.perf_counter() - began)

    return measure


def measure(
    skills: SkillsParams, mapped: MappingParams, params: TransferParams, repeats: int
) -> list[Figure]:
    """All figures, each printed as soon as it is known."""
    wide_critics = tuple(WIDE * width for width in params.critic_hidden)
    larger: dict[str, list[tuple[str, dict[str, Any]]]] = {
        "skill_vae": [_many(skills.vae), _wide(skills.vae)],
        "priors_of_three_tasks": [_many(skills.prior), _wide(skills.prior)],
        "mapping": [_many(mapped)],
        "learner": [_many(params), (f"/critics_x{WIDE}", {"critic_hidden": wide_critics})],
    }
    made: dict[str, Callable[[dict[str, Any], int], Trained]] = {
        "skill_vae": lambda change, n: vae(replace(skills.vae, steps=n, **change)),
        "priors_of_three_tasks": lambda change, n: priors(
            skills, replace(skills.prior, steps=n, **change)
        ),
        "mapping": lambda change, n: mapping(skills, replace(mapped, steps=n, **change)),
        "learner": lambda change, n: learner(skills, mapped, replace(params, **change), n),
    }
    parts = {
        f"{part}{name}": (made[part](change, steps), steps)
        for part, changes in larger.items()
        for name, change, steps in (("", {}, STEPS), *((*one, FEWER) for one in changes))
    }
    figures = []
    for name, (trained, steps) in parts.items():
        sides = (_rate(trained, side, steps) for side in ("cuda", "cpu"))
        figures.append(compare(name, "steps/s", 1.0, *sides, repeats))
        show(figures[-1])
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    if not torch.cuda.is_available():
        print("torch finds no CUDA device; nothing is measured")
        return
    torch.set_num_threads(1)
    torch.manual_seed(0)
    figures = measure(SkillsParams(), MappingParams(), TransferParams(), arguments.repeats)
    device = torch.cuda.get_device_name()
    print(write("devices", figures, arguments.out, accelerator=device))


if __name__ == "__main__":
    main()
