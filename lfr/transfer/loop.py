"""Algorithm 2: act by skills in the target's simulations, store, update, evaluate, checkpoint.

One round executes one skill in each simulation and, meanwhile, makes the updates that are due.
Everything that the next round depends on is in ``state``, so a run that is killed and resumed ends
bit for bit as one that was not.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from lfr.artifacts import as_json
from lfr.errors import LfrError
from lfr.networks.device import device_named
from lfr.transfer.actor import as_tensor
from lfr.transfer.checkpoint import load_checkpoint, save_checkpoint
from lfr.transfer.environment import Array, Outcome, Resumable, RewardRule, RunningEpisode
from lfr.transfer.learner import Learner
from lfr.transfer.means import Means
from lfr.transfer.methods.initialization import Initialization
from lfr.transfer.observer import CurvePoint, EpisodeRecord, Observer
from lfr.transfer.replay import Batch, Replay
from lfr.transfer.rollout import evaluate
from lfr.transfer.starts import evaluation_starts, learning_start
from lfr.transfer.transfer_params import TransferParams


@dataclass
class Progress:
    """The counts of a run."""

    env_steps: int = 0  # control steps executed while learning: the axis of every curve
    skills: int = 0
    episodes: int = 0  # begun
    updates: int = 0
    skills_before_updates: int = 0  # executed before the buffer held a batch


class TransferLoop:
    """A learning run of one method on one target task.

    Args:
        initialization: policy, frozen prior, decoder and normalizer (`lfr.transfer.methods`).
        simulations: of the target arm and task, ``params.simulations`` of them.
        seed: of the run; with it, everything is determined.
        work: where checkpoints are kept; None keeps none.
        observer: is told of episodes, updates and evaluations.

    Raises:
        LfrError: another number of simulations.
        DataError: a checkpoint in ``work`` that is damaged or of another run.
    """

    def __init__(
        self,
        initialization: Initialization,
        simulations: Sequence[Resumable],
        params: TransferParams,
        seed: int,
        work: Path | None = None,
        observer: Observer | None = None,
    ) -> None:
        if len(simulations) != params.simulations:
            raise LfrError(f"found {len(simulations)} simulations, expected {params.simulations}")
        self.device = device_named(params.device)
        self.actor = initialization.actor.to(self.device)
        self.params, self.seed, self.work = params, seed, work
        size, latent_dim = len(initialization.layout_names), initialization.latent_dim
        self.observer = observer or Observer()
        self.rule = RewardRule(params.reward, params.dense_scale)
        self.generator = torch.Generator().manual_seed(seed)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)  # the critics' initial weights
            self.learner = Learner(
                self.actor.policy, initialization.normalizer, size, latent_dim, params,
                self.generator, self.actor.distribution, self.device,
            )  # fmt: skip
        self.replay = Replay(params.replay, size, latent_dim)
        self.progress = Progress()
        self.worker = ThreadPoolExecutor(1, "acting")
        self._began, self._before = time.perf_counter(), 0.0
        self.curve: list[CurvePoint] = []
        self.means = Means()  # since the last evaluation
        self.identity = as_json(
            {"params": as_json(params), "seed": seed, "layout": initialization.layout_names}
        )
        self.episodes = [RunningEpisode(simulation) for simulation in simulations]
        if not self._resume():
            for episode in self.episodes:
                self._begin(episode)
            self._evaluate()

    def run(self) -> list[CurvePoint]:
        """Learn until ``params.steps`` environment steps are done; returns the curve."""
        params, progress = self.params, self.progress
        while progress.env_steps < params.steps:
            before = progress.env_steps
            self._round()
            self.observer.on_progress(min(progress.env_steps, params.steps), params.steps)
            done = progress.env_steps >= params.steps
            if done or _passed(before, progress.env_steps, params.evaluate_every):
                self._evaluate()
            if done or _passed(before, progress.env_steps, params.checkpoint_every):
                self._checkpoint()
        return self.curve

    def _round(self) -> None:
        """One skill in each simulation; meanwhile the updates that earlier skills have made due.

        The simulation releases the GIL, so the two share the cores. What the round's skills gave is
        stored after its updates: always, however long either takes, so a run stays determined.
        """
        observations = self._seen([episode.observation for episode in self.episodes])
        choice = self.actor.choose(observations, self.generator)
        actions = self.actor.decode(choice.z, observations)
        executing = self.worker.submit(self._execute, actions)
        try:
            self._update()
        finally:
            outcomes = executing.result()  # also if the learner diverged: nothing is left running
        self._store(observations, choice.z, outcomes)
        self.progress.skills += len(outcomes)
        for episode, outcome in zip(self.episodes, outcomes, strict=True):
            self.progress.env_steps += outcome.steps
            if outcome.over:
                self._end(episode, valid=outcome.valid)
                self._begin(episode)

    @property
    def seconds(self) -> float:
        """Wall-clock spent so far, that of earlier processes up to their last checkpoint too."""
        return self._before + time.perf_counter() - self._began

    def _execute(self, actions: Sequence[Array]) -> list[Outcome]:
        """The skills, (n, A) each, one in each simulation."""
        return [
            episode.execute(skill, self.rule)
            for episode, skill in zip(self.episodes, actions, strict=True)
        ]

    def _seen(self, observations: Sequence[Array]) -> Tensor:
        """Observations (D,) of B simulations as the networks take them, (B, D)."""
        return as_tensor(np.stack(observations)).to(self.device)

    def _store(self, observations: Tensor, z: Tensor, outcomes: Sequence[Outcome]) -> None:
        keep = [i for i, outcome in enumerate(outcomes) if outcome.valid]
        if not keep:
            return
        after = self._seen([outcomes[i].observation for i in keep])
        rewards = torch.tensor([outcomes[i].reward for i in keep])
        # A terminal state ends the return; a time limit only ends the episode, so it bootstraps.
        discounts = torch.tensor(
            [0.0 if outcomes[i].terminated else self.params.gamma for i in keep]
        )
        before = observations[keep]
        with torch.no_grad():  # of both at once: with rows this few, a call costs what they do not
            mu, log_sigma = (x.chunk(2) for x in self.actor.prior(torch.cat([before, after])))
        priors = mu[0], log_sigma[0], mu[1], log_sigma[1]
        self.replay.add(Batch(before, z[keep], rewards, discounts, after, *priors))

    def _update(self) -> None:
        """The updates that are due: ``updates_per_skill`` for each skill since the first batch."""
        params, progress = self.params, self.progress
        if len(self.replay) < params.batch:
            progress.skills_before_updates = progress.skills
            return
        skills = progress.skills - progress.skills_before_updates
        critics_only = progress.env_steps < params.warm_up
        due = int(params.updates_per_skill * skills) - progress.updates
        if due <= 0:
            return
        batch = self.replay.sample(due * params.batch, self.generator)
        infos = self.learner.update(batch, due, critics_only=critics_only)
        progress.updates += due
        info = {}
        for name in {name: None for one in infos for name in one}:
            values = torch.stack([one[name] for one in infos if name in one]).tolist()
            self.means.add(name, sum(values), len(values))
            info[name] = sum(values) / len(values)
        if not np.isfinite(list(info.values())).all():
            raise LfrError(
                f"the learner diverged after {progress.updates} updates: {info}; "
                "lower transfer.critic_lr or transfer.policy_lr"
            )
        self.observer.on_update(progress.env_steps, progress.updates, info)

    def _begin(self, episode: RunningEpisode) -> None:
        episode.start(learning_start(self.seed, self.progress.episodes))
        self.progress.episodes += 1

    def _end(self, episode: RunningEpisode, *, valid: bool) -> None:
        self.means.add("learning_success", float(episode.success), 1)
        self.observer.on_episode(
            EpisodeRecord(
                self.progress.env_steps,
                episode.seed,
                episode.length,
                episode.total,
                episode.success,
                valid,
            )
        )

    def _evaluate(self) -> None:
        """A point of the curve. The learning episodes step aside and go on afterwards."""
        suspended = [episode.suspend() for episode in self.episodes]
        seeds = evaluation_starts(self.seed, self.params.evaluation_episodes)
        rule = dataclasses.replace(self.rule, until_success=True)
        outcomes = evaluate(self.actor, [e.simulation for e in self.episodes], seeds, rule)
        for episode, state in zip(self.episodes, suspended, strict=True):
            episode.restore(*state)
        means = self.means.take()
        names = ("learning_success", "kl", "alpha", "sigma", "q", "critic_loss", "policy_loss")
        point = CurvePoint(
            env_steps=self.progress.env_steps,
            updates=self.progress.updates,
            episodes=self.progress.episodes,
            success=float(np.mean([o.success for o in outcomes])),
            mean_return=float(np.mean([o.total_reward for o in outcomes])),
            mean_length=float(np.mean([o.length for o in outcomes])),
            **{name: means.get(name) for name in names},
        )
        self.curve.append(point)
        self.observer.on_evaluation(point)

    def _checkpoint(self) -> None:
        if self.work is None:
            return
        content, tensors = self.state()
        save_checkpoint(self.work, self.progress.env_steps, content, tensors)
        # A resumed run goes on from what was written; so does this one, to be the same run even on
        # a simulation whose restored state differs in the last bit.
        self._restore_episodes(content, tensors)

    def state(self) -> tuple[dict[str, Any], dict[str, Tensor]]:
        """Everything that the rest of the run depends on, as JSON and as tensors."""
        tensors = {f"learner.{k}": v for k, v in self.learner.state().items()}
        tensors |= {f"replay.{k}": v for k, v in self.replay.state().items()}
        suspended = [episode.suspend() for episode in self.episodes]
        for i, (state, observation, _) in enumerate(suspended):
            tensors[f"episode.{i}.state"] = torch.from_numpy(state)
            tensors[f"episode.{i}.observation"] = torch.from_numpy(observation)
        content = {
            "identity": self.identity,
            "progress": dataclasses.asdict(self.progress),
            "curve": [dataclasses.asdict(point) for point in self.curve],
            "means": self.means.state(),
            "episodes": [counts for _, _, counts in suspended],
            "seconds": self.seconds,
        }
        return content, tensors

    def _resume(self) -> bool:
        found = load_checkpoint(self.work, self.identity) if self.work is not None else None
        if found is None:
            return False
        content, tensors = found
        self.learner.load_state(_part(tensors, "learner."))
        self.replay.load_state(_part(tensors, "replay."))
        self.progress = Progress(**content["progress"])
        self.curve = [CurvePoint(**point) for point in content["curve"]]
        self._before = content["seconds"]
        self.means.load_state(content["means"])
        self._restore_episodes(content, tensors)
        return True

    def _restore_episodes(self, content: dict[str, Any], tensors: dict[str, Tensor]) -> None:
        for i, (episode, counts) in enumerate(zip(self.episodes, content["episodes"], strict=True)):
            state: Array = tensors[f"episode.{i}.state"].numpy()
            episode.restore(state, tensors[f"episode.{i}.observation"].numpy(), counts)


def _passed(before: int, after: int, every: int) -> bool:
    return before // every < after // every


def _part(tensors: dict[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}
