"""Demonstrations as MCAP logs: the expert tries seed after seed until enough attempts succeed."""

from __future__ import annotations

import math
import os
import shutil
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lfr.artifacts import as_json, write_whole
from lfr.demos.attempt import AttemptParams, attempt
from lfr.errors import LfrError, ParameterError
from lfr.jobs import Job, run_jobs
from lfr.seeds import episode_seed
from lfr.sim.camera_params import CameraParams, check_names

if TYPE_CHECKING:
    from lfr.data.log import CameraModel, Pose
    from lfr.sim.camera import Camera
    from lfr.sim.simulation import Simulation


@dataclass(frozen=True)
class RecordParams:
    """Parameters of the record stage: section ``record`` of params.yaml."""

    episodes: int = 50  # successful demonstrations per robot and task
    most_attempts: float = 4.0  # per demonstration, before the expert is given up
    attempt: AttemptParams = field(default_factory=AttemptParams)
    cameras: tuple[CameraParams, ...] = (CameraParams(),)  # whose pictures are logged

    def __post_init__(self) -> None:
        if self.episodes < 1 or self.most_attempts < 1:
            raise ParameterError(
                "episodes and most_attempts must be at least 1, "
                f"found {self.episodes} and {self.most_attempts}"
            )
        check_names(self.cameras)


@dataclass(frozen=True)
class AttemptJob:
    """One attempt; its log goes to ``folder``."""

    robot: str
    task: str
    seed: int
    folder: str
    attempt: AttemptParams
    cameras: tuple[CameraParams, ...]


def record_demonstrations(
    robot: str, task: str, params: RecordParams, out: Path, work: Path
) -> dict[str, Any]:
    """Record ``params.episodes`` demonstrations as ``out/episode-000000.mcap`` and so on.

    Attempts run over the seeds 0, 1, 2, ...; the first that succeed are kept, in the order of
    their seeds. Without OpenGL the logs hold states alone, and a line on stderr says so.

    Args:
        out: the logs' folder, written whole at the end.
        work: keeps each finished attempt, so that a killed recording goes on.

    Returns:
        What was attempted and what came of it, for the stage's metrics.

    Raises:
        LfrError: the expert succeeds too seldom.
    """
    cameras = params.cameras if _can_draw(params.cameras) else ()

    def job(seed: int) -> Job:
        spec = AttemptJob(robot, task, seed, str(work), params.attempt, cameras)
        return Job(record_attempt, spec)

    try:
        found = record_successes(
            job, params.episodes, params.most_attempts, out, work, f"record {robot}-{task}"
        )
    except TooFewSuccesses as error:
        raise LfrError(
            f"the expert succeeded in {error} at {task} on {robot}; expected {params.episodes} "
            "successes; mend record.attempt"
        ) from None
    return {**found, "cameras": [camera.name for camera in cameras]}


class TooFewSuccesses(LfrError):
    """How many of how many attempts have succeeded."""


def record_successes(
    job: Callable[[int], Job],
    wanted: int,
    most_attempts: float,
    out: Path,
    work: Path,
    description: str,
) -> dict[str, Any]:
    """Attempt seed after seed until enough succeed; their logs, in order, go to ``out``.

    Args:
        job: of the seed of one attempt; it leaves its log at `log_path` of ``work`` if it succeeds,
            and gives seed, success and frames.
        most_attempts: for each that is wanted, before it is given up.

    Raises:
        TooFewSuccesses: then.
    """
    attempts: list[dict[str, Any]] = []
    kept: list[dict[str, Any]] = []
    most = math.ceil(most_attempts * wanted)
    while len(kept) < wanted:
        if len(attempts) >= most:
            raise TooFewSuccesses(f"{len(kept)} of {len(attempts)} attempts")
        missing = wanted - len(kept)
        # After a first round, a few more than are missing: another round costs another start.
        count = math.ceil(1.5 * missing) if attempts else missing
        seeds = range(len(attempts), min(len(attempts) + count, most))
        jobs = [job(episode_seed("demonstration", seed)) for seed in seeds]
        attempts += run_jobs(jobs, work=work, description=description, unit="attempt").values()
        kept = [one for one in attempts if one["success"]][:wanted]
    with write_whole(out) as partial:
        partial.mkdir()
        for number, one in enumerate(kept):
            _place(log_path(work, one["seed"]), partial / f"episode-{number:06d}.mcap")
    lengths = [one["frames"] for one in kept]
    successes = sum(one["success"] for one in attempts)
    return {
        "episodes": len(kept),
        "attempts": len(attempts),
        "failures": len(attempts) - successes,
        "expert_success": successes / len(attempts),
        "frames": sum(lengths),
        "length": {
            "mean": float(np.mean(lengths)),
            "median": float(np.median(lengths)),
            "min": min(lengths),
            "max": max(lengths),
        },
        "seeds": {"first": kept[0]["seed"], "last": kept[-1]["seed"]},
        "failed_seeds": [one["seed"] for one in attempts if not one["success"]],
    }


def record_attempt(job: AttemptJob) -> dict[str, Any]:
    """Run one attempt and log it; a failed one leaves no log. The same job, the same bytes."""
    from lfr.data.episode import EpisodeInfo
    from lfr.data.log import EpisodeLog, Frame
    from lfr.sim.simulation import simulation

    running, shown = simulation(job.robot, job.task), _shown(job.robot, job.task)
    cameras = _cameras(job.robot, job.task, job.cameras) if job.cameras else ()
    extra = {"expert": str(as_json(job.attempt))}
    info = EpisodeInfo.of(running.embodiment, running.task, job.seed, extra)
    models = {camera.name: _model(camera, running) for camera in cameras}
    moments = list(attempt(running, job.attempt, job.seed))
    success = any(moment.success for moment in moments)
    if not success:  # before anything is drawn
        return {"seed": job.seed, "success": False, "frames": len(moments)}
    with EpisodeLog(log_path(Path(job.folder), job.seed), info, models) as log:
        for moment in moments:
            # A second simulation shows the moment before the action; the first is one step on.
            shown.set_state(moment.simulator_state)
            log.frame(
                Frame(
                    observation=moment.observation,
                    joint_position=moment.joint_position,
                    joint_velocity=shown.joint_velocity(),
                    action=moment.action,
                    executed_action=moment.executed,
                    reward=moment.reward,
                    success=moment.success,
                    simulator_state=moment.simulator_state,
                    body_poses=_poses(shown, cameras),
                    images={camera.name: camera.render(shown) for camera in cameras},
                )
            )
        log.finish(running.state(), _poses(running, cameras))
    return {"seed": job.seed, "success": True, "frames": len(moments)}


def log_path(folder: Path, seed: int) -> Path:
    """Where the attempt of a seed is logged before it is numbered."""
    return folder / f"seed-{seed:06d}.mcap"


@cache
def _shown(robot: str, task: str) -> Any:
    """This process's simulation for looking at states that another one has left."""
    from lfr.sim.simulation import Simulation

    return Simulation(robot, task)


@cache
def _cameras(robot: str, task: str, params: tuple[CameraParams, ...]) -> tuple[Camera, ...]:
    from lfr.sim.camera import open_cameras

    return open_cameras(robot, task, params)


def _model(camera: Camera, simulation: Simulation) -> CameraModel:
    """What is logged of a camera once: all of it, but for the pose of one that moves."""
    from lfr.data.log import CameraModel

    intrinsics, *pose = camera.projection(simulation)
    return CameraModel(camera.width, camera.height, intrinsics, *(() if camera.moves else pose))


def _poses(simulation: Simulation, cameras: Iterable[Camera]) -> dict[str, Pose]:
    """Of the bodies, and of the cameras that move with one of them."""
    poses = {camera.name: camera.projection(simulation) for camera in cameras if camera.moves}
    moving = {name: (seen.position, seen.quaternion) for name, seen in poses.items()}
    return {**simulation.body_poses(), **moving}


def _can_draw(cameras: tuple[CameraParams, ...]) -> bool:
    from lfr.sim.camera import camera_available

    if cameras and not camera_available():
        print(
            "lfr: no OpenGL, so no video is recorded; on Debian and Ubuntu install libegl1 and "
            "libegl-mesa0",
            file=sys.stderr,
        )
        return False
    return bool(cameras)


def _place(log: Path, final: Path) -> None:
    """The log under its final name: the same file twice where the file system can do that."""
    try:
        os.link(log, final)
    except OSError:
        shutil.copyfile(log, final)
