"""Behaviour cloning of a recurrent policy by maximum likelihood."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import torch

from lfr.data.windows import DemonstrationSet
from lfr.jobs import report
from studies.imitation.imitation_params import ImitationParams
from studies.imitation.recurrent_gmm import RecurrentGMM
from studies.imitation.sequences import Sequences

CHUNK = 512  # sequences whose likelihood is taken together, to spare memory


def train_bc(demonstrations: DemonstrationSet, params: ImitationParams, seed: int) -> RecurrentGMM:
    """A policy that gives the demonstrations' actions the highest likelihood.

    The loss is the mean of -log p(a_t | o_1 ... o_t) over sequences and steps. Sequences are drawn
    with replacement; robomimic goes through them in a random order.

    Raises:
        ValueError: there are no demonstrations.
    """
    if not len(demonstrations):
        raise ValueError("nothing to imitate: no demonstrations")
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    policy = RecurrentGMM(
        demonstrations.observation_names, demonstrations.actions.shape[-1], params.hidden,
        params.layers, params.modes, params.min_std, params.horizon,
    )  # fmt: skip
    policy.normalizer.fit(demonstrations.observations, demonstrations.observation_names)
    sequences = Sequences(demonstrations, params.horizon)
    optimizer = torch.optim.Adam(policy.parameters(), params.learning_rate, fused=True)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, params.updates)
    with _denormals_are_zero():
        for update in range(params.updates):
            index = torch.randint(len(sequences), (params.batch,), generator=generator)
            batch = sequences.gather(index)
            mixture, _ = policy(batch.observations)
            loss = -mixture.log_likelihood(batch.actions).mean()
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            optimizer.step()
            schedule.step()
            report(update + 1, params.updates)
    return policy.eval()


@torch.no_grad()
def log_likelihood(policy: RecurrentGMM, demonstrations: DemonstrationSet) -> float | None:
    """Mean log-likelihood of an action, in nats, over all sequences; None where there are none."""
    if not len(demonstrations):
        return None
    sequences = Sequences(demonstrations, policy.horizon)
    total = 0.0
    for index in torch.arange(len(sequences)).split(CHUNK):
        batch = sequences.gather(index)
        mixture, _ = policy(batch.observations)
        total += float(mixture.log_likelihood(batch.actions).double().sum())
    return total / (len(sequences) * policy.horizon)


@contextlib.contextmanager
def _denormals_are_zero() -> Iterator[None]:
    """Numbers below 1e-38 as zero: gradients vanish into them, and the CPU is slow with them."""
    torch.set_flush_denormal(True)
    try:
        yield
    finally:
        torch.set_flush_denormal(False)
