"""Demonstrations in an environment of an arm's own, by a policy of somebody's."""

from __future__ import annotations

import json
import logging
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import as_json, file_hash, fingerprint, parse_json
from lfr.columns import ActionPart, Part
from lfr.conversion import AS_IT_IS
from lfr.data.dataset import pack_dataset
from lfr.data.episode import ACTION, DONE, IMAGES, REWARD, STATE, SUCCESS, EpisodeInfo, Feature
from lfr.data.episode import observed as observed_first
from lfr.data.log import EpisodeLog, Frame
from lfr.data.log_reader import list_logs
from lfr.demos.recorder import TooFewSuccesses, log_path, record_successes
from lfr.environments.entries import column_of, succeeded
from lfr.environments.process import EnvironmentFailure, EnvironmentProcess
from lfr.environments.simulation import CAMERA, made
from lfr.errors import LfrError, UnknownNameError
from lfr.external import EnvironmentParams, ExternalArm
from lfr.jobs import Job
from lfr.lerobot_policy import LeRobotPolicy
from lfr.records import from_mapping

Array = NDArray[np.float64]
Answer = Callable[[Any, Mapping[str, NDArray[np.uint8]]], Any]
"""The action for what an environment observes, and its pictures."""
PERSISTENCE = 0.22  # s, in which the noise forgets: it leads further than white noise would
NOTHING = np.zeros(0)  # Gymnasium knows no state of an environment


@dataclass(frozen=True)
class Manner:
    """How demonstrations are made.

    Attributes:
        policy: ``module:name`` of what makes a policy for one episode, called without arguments: it
            is called with what the environment observes, or its ``get_action`` is, and answers the
            environment's action. Or the folder of a policy in LeRobot's format.
        noise: standard deviation of what is added to each action as it is carried out, in shares of
            half its range; the one that is recorded is the policy's own (DART, Laskey et al. 2017).
        linger: seconds recorded after the first success.
        content: what ``policy`` is: another file is another policy.
    """

    policy: str
    noise: float = 0.0
    linger: float = 0.5
    content: str = ""


@dataclass(frozen=True)
class EpisodeJob:
    """One attempt; its log goes to ``folder``."""

    arm: str
    task: str
    instruction: str
    fps: int
    observation: tuple[Part, ...]
    action: ActionPart
    environment: EnvironmentParams
    code: str
    manner: Manner
    seed: int
    folder: str

    @property
    def name(self) -> str:
        """For messages."""
        return f"{self.arm}, {self.task}"


def record_in_environment(
    robot: str,
    arm: ExternalArm,
    task: str,
    manner: Manner,
    episodes: int,
    most_attempts: float,
    logs: Path,
    dataset: Path,
    work: Path,
) -> dict[str, Any]:
    """Record successful episodes as MCAP logs and as a LeRobot dataset.

    Its columns are those that the arm's environment names, and ``action``; where that draws
    (``render_mode: rgb_array`` among its ``kwargs``), its pictures too.

    Args:
        logs, dataset: folders, each written whole.
        work: keeps each finished attempt, so that a killed recording goes on.

    Returns:
        What was attempted and what came of it, as `record_successes`.

    Raises:
        UnknownNameError: the arm has no environment for the task.
        LfrError: no such policy or environment; it observes something else than is described; or
            the policy succeeds too seldom.
    """
    if task not in arm.environments:
        raise UnknownNameError("environment for task", task, arm.environments)
    if arm.fps != int(arm.fps):
        raise LfrError(f"{robot}: LeRobot's datasets have whole control steps a second, "
                       f"found {arm.fps:g}")  # fmt: skip
    params, known = arm.environments[task], arm.tasks.get(task)
    said = (known.instruction if known else None) or task
    manner = Manner(manner.policy, manner.noise, manner.linger, _content(manner.policy))
    trial = made(params, f"{robot}, {task}")
    observation = (known.observation if known else ()) or arm.observation
    code = trial.about.code
    trial.close()

    def job(seed: int) -> Job:
        spec = EpisodeJob(robot, task, said, int(arm.fps), observation, arm.action, params, code,
                          manner, seed, str(work))  # fmt: skip
        return Job(record_episode, spec)

    try:
        found = record_successes(job, episodes, most_attempts, logs, work, f"record {robot}-{task}")
    except TooFewSuccesses as error:
        raise LfrError(
            f"{manner.policy} succeeded in {error} at {task} on {robot}; expected {episodes} "
            "successes"
        ) from None
    pack_dataset(list_logs(logs), dataset, fps=int(arm.fps))
    return found


def record_episode(job: EpisodeJob) -> dict[str, Any]:
    """Run one attempt and log it; a failed one leaves no log.

    One in which the environment raises, or its process ends, has failed.
    """
    environment = _environment(json.dumps(as_json(job.environment)), job.name)
    try:
        frames, success = _run(job, environment)
    except EnvironmentFailure as error:
        logging.error("%s: the environment has failed: %s\n%s", job.name, error, error.trace)
        _environment.cache_clear()  # the next attempt's is another one
        frames, success = 0, False
    return {"seed": job.seed, "success": success, "frames": frames}


def _run(job: EpisodeJob, environment: EnvironmentProcess) -> tuple[int, bool]:
    """How many frames, and whether one of them succeeded; then they are logged."""
    params, box = job.environment, environment.about.action_space
    if not isinstance(box, gymnasium.spaces.Box) or len(box.shape) != 1:
        raise LfrError(f"{job.name}: the environment's action is {box}, expected a Box of (A,)")
    rng = np.random.default_rng([job.seed, 1])
    rho, half = math.exp(-1.0 / (job.fps * PERSISTENCE)), (box.high - box.low) / 2.0
    horizon = params.horizon or environment.about.horizon
    if horizon is None:
        raise LfrError(f"{job.name}: the environment does not end by itself; say 'horizon'")
    policy = _policy(job.manner.policy)
    observed = environment.reset(job.seed)
    columns = _columns(job, observed)
    answer = policy.begin(job)
    info = EpisodeInfo(
        job.arm, job.task, job.seed, job.instruction, _features(job, columns, box), fps=job.fps,
        extra={"policy": job.manner.policy, "environment": params.id,
               "noise": f"{job.manner.noise:g}"},
    )  # fmt: skip
    drift, frames, end, success = np.zeros(box.shape), 0, horizon, False
    with EpisodeLog(log_path(Path(job.folder), job.seed), info) as log:
        while frames < end:
            picture = {CAMERA: environment.render()} if environment.about.draws else {}
            wanted = np.asarray(answer(observed, picture), np.float64).ravel()
            if wanted.shape != box.shape or not np.isfinite(wanted).all():
                raise LfrError(f"{job.manner.policy} answers {wanted}, expected {box}")
            wanted = np.clip(wanted, box.low, box.high)
            fresh = job.manner.noise * half * rng.standard_normal(box.shape)
            drift = rho * drift + math.sqrt(1.0 - rho**2) * fresh
            executed = np.clip(wanted + drift, box.low, box.high).astype(box.dtype)
            before = np.concatenate(list(_columns(job, observed).values()))
            observed, reward, over, said = environment.step(executed)
            reached = succeeded(reward, said, params, job.name)
            log.frame(
                Frame(before, None, wanted, reward, reached, NOTHING,
                      executed_action=executed.astype(np.float64), images=picture)
            )  # fmt: skip
            frames += 1
            if reached and not success:
                success, end = True, min(end, frames + round(job.manner.linger * job.fps))
            if over:
                break
        if success:
            log.finish(NOTHING)
    return frames, success


def _columns(job: EpisodeJob, observed: Any) -> dict[str, Array]:
    """By name, in the order in which a log has them."""
    names = observed_first(job.environment.observation or (STATE,))
    return {name: column_of(observed, name, job.environment, job.name) for name in names}


def _features(
    job: EpisodeJob, columns: Mapping[str, Array], box: gymnasium.spaces.Box
) -> dict[str, Feature]:
    parts: dict[str, Part | ActionPart] = {part.column: part for part in job.observation}
    found = {
        name: Feature(name, "float32", _names(parts.get(name), name, len(values)),
                      f"{job.environment.observation.get(name, 'all')} of the observation")
        for name, values in columns.items()
    }  # fmt: skip
    action = _names(job.action, ACTION, *box.shape)
    found[ACTION] = Feature(ACTION, "float32", action, "the environment's action")
    found[REWARD] = Feature(REWARD, "float32", ("reward",), "the environment's reward")
    found[SUCCESS] = Feature(SUCCESS, "bool", ("success",), "what the environment says of success")
    found[DONE] = Feature(DONE, "bool", ("done",), "true at the episode's last frame")
    return found


def _names(part: Part | ActionPart | None, column: str, size: int) -> tuple[str, ...]:
    """What the arm calls a column's numbers, where it takes all of them as they are; else they are
    counted: what a number becomes is no name for what it is."""
    if part is not None and not part.dims and len(part.names) == size and _is_plain(part):
        return part.names
    return tuple(f"{column.rpartition('.')[2]}.{i}" for i in range(size))


def _is_plain(part: Part | ActionPart) -> bool:
    return isinstance(part, ActionPart) or (part.minus is None and part.conversion == AS_IT_IS)


class _Scripted:
    """Makes a policy for each episode by calling what ``module:name`` names."""

    def __init__(self, name: str) -> None:
        module, _, attribute = name.partition(":")
        try:
            self._make: Any = getattr(import_module(module), attribute)
        except (ImportError, AttributeError, ValueError) as error:
            raise LfrError(
                f"--policy {name}: {error}; expected module:name of what makes a policy, or the "
                "folder of a policy in LeRobot's format"
            ) from error

    def begin(self, job: EpisodeJob) -> Answer:
        made: Any = self._make()
        answer = getattr(made, "get_action", made)
        return lambda observed, _: answer(observed)


class _LeRobot:
    """A policy in LeRobot's format, which is given the columns that it asks for."""

    def __init__(self, folder: Path) -> None:
        self._policy = LeRobotPolicy(folder)

    def begin(self, job: EpisodeJob) -> Answer:
        self._policy.reset()

        def answer(observed: Any, pictures: Mapping[str, NDArray[np.uint8]]) -> Array:
            given: dict[str, NDArray[Any]] = {}
            for key in self._policy.columns:
                picture = pictures.get(key.removeprefix(IMAGES))
                if picture is not None:
                    given[key] = np.moveaxis(picture, -1, 0).astype(np.float32) / 255.0
                else:
                    values = column_of(observed, key, job.environment, job.name)
                    given[key] = values.astype(np.float32)
            return self._policy.act(given, job.instruction)

        return answer


@cache
def _policy(name: str) -> _Scripted | _LeRobot:
    return _LeRobot(Path(name)) if Path(name).is_dir() else _Scripted(name)


@cache
def _environment(params: str, name: str) -> EnvironmentProcess:
    """This process's environment; ``params`` is its `EnvironmentParams` as JSON."""
    return made(from_mapping(EnvironmentParams, parse_json(params), name), name)


def _content(policy: str) -> str:
    """A fingerprint of a folder, or of the file of a module.

    Raises:
        LfrError: there is neither.
    """
    if Path(policy).is_dir():
        return fingerprint(Path(policy))
    _policy(policy)
    file = sys.modules[policy.partition(":")[0]].__file__
    return file_hash(Path(file)) if file else ""
