"""Gradient updates per second on one core: the transfer learner against Stable-Baselines3's SAC.

    python -m benchmarks.learner [--repeats 15] [--out results/benchmarks]

Both sides train the same networks (the prior's MLP and G as the policy, normalised observations,
critics with layer normalisation) on batches of the same size from a full replay buffer, on one
thread. Stable-Baselines3's own ``SAC.train`` runs untouched; it makes a policy step in every
update, so the learner is compared both as it is by default and with a policy step in every update.
The sides alternate; times are the process's own, which what else the machine does falsifies least.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from pathlib import Path

import torch

from benchmarks._figures import FOLDER, Figure, Measurement, compare, show, write
from lfr.mapping.generator import Generator
from lfr.mapping.mapping_params import MappingParams
from lfr.params import read_section
from lfr.skills.prior import SkillPrior
from lfr.skills.skill_params import SkillsParams
from lfr.skills.vae import SkillVAE
from lfr.transfer.learner import Learner
from lfr.transfer.methods.initialization import Initialization, initialize_from
from lfr.transfer.replay import Batch, Replay
from lfr.transfer.transfer_params import TransferParams

OBSERVATION = 30  # of NutAssembly, the widest
ROWS = 5_000  # in the replay buffers
ROUND = 48  # updates timed at a time, at least
RATIO_GOAL, RATE_GOAL = 2.0, 250.0  # against Stable-Baselines3; updates/s


def untrained(params: TransferParams) -> Initialization:
    """What a run begins with, from untrained networks of the default shapes."""
    skills = read_section(SkillsParams, "skills")
    mapping = read_section(MappingParams, "mapping")
    latent = skills.vae.latent_dim
    names = [f"{'a_to_b' if i >= OBSERVATION // 2 else 'a'}{i}_pos" for i in range(OBSERVATION)]
    prior = SkillPrior(names, latent, skills.prior.hidden, skills.prior.layers)
    phi = Generator(latent, mapping.hidden, mapping.layers)
    decoder = SkillVAE(skills.vae.horizon, 7, latent, skills.vae.hidden)
    return initialize_from(prior, phi, decoder, params, prior)


def ours(params: TransferParams) -> Measurement:
    """Updates per second of the learner, its draws from the replay buffer included."""
    begun, generator = untrained(params), torch.Generator().manual_seed(0)
    latent = begun.latent_dim
    replay = Replay(ROWS, OBSERVATION, latent)
    observation, after = torch.randn(2, ROWS, OBSERVATION)
    with torch.no_grad():
        prior, next_prior = begun.actor.prior(observation), begun.actor.prior(after)
    z, reward, discount = (
        torch.randn(ROWS, latent), torch.rand(ROWS), torch.full((ROWS,), params.gamma)
    )  # fmt: skip
    replay.add(Batch(observation, z, reward, discount, after, *prior, *next_prior))
    learner = Learner(begun.actor.policy, begun.normalizer, OBSERVATION, latent, params, generator)

    due = max(1, round(params.updates_per_skill * params.simulations))  # as the transfer loop does
    rounds = -(-ROUND // due)

    def measure() -> float:
        began = time.process_time()
        for _ in range(rounds):
            learner.update(replay.sample(due * params.batch, generator), due)
        return rounds * due / (time.process_time() - began)

    return measure


def theirs(params: TransferParams) -> Measurement:
    """Updates per second of Stable-Baselines3's SAC with the same networks."""
    from benchmarks._baselines import soft_actor_critic

    begun = untrained(params)
    model = soft_actor_critic(begun, OBSERVATION, params, ROWS)

    def measure() -> float:
        began = time.process_time()
        model.train(gradient_steps=ROUND, batch_size=params.batch)
        return ROUND / (time.process_time() - began)

    return measure


def measure(params: TransferParams, repeats: int) -> list[Figure]:
    """All figures, each printed as soon as it is known."""
    every = dataclasses.replace(params, policy_every=1)
    unit, baseline = "updates/s", theirs(params)
    found = [
        compare("stable_baselines3", unit, RATIO_GOAL, ours(params), baseline, repeats),
        compare("stable_baselines3/policy_step_each_update", unit, RATIO_GOAL, ours(every),
                baseline, repeats),
        compare("updates_per_second", unit, 1.0, ours(params), lambda: RATE_GOAL, repeats),
    ]  # fmt: skip
    for figure in found:
        show(figure)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(0)
    params = read_section(TransferParams, "transfer")
    print(write("learner", measure(params, arguments.repeats), arguments.out))


if __name__ == "__main__":
    main()
