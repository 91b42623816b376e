"""A Gymnasium environment in a process of its own: what ends it ends nothing else."""

from __future__ import annotations

import contextlib
import inspect
import os
import subprocess
import sys
import traceback
import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import file_hash

LAST = 10.0  # seconds that a process is given to close its environment


@dataclass(frozen=True)
class About:
    """What an environment says of itself.

    Attributes:
        action_space: of its actions.
        horizon: control steps after which it ends an episode; None where it does not say.
        draws: it answers `render` with a picture.
        code: SHA-256 of the file that its class stands in; "" where there is none.
    """

    action_space: gymnasium.Space[Any]
    horizon: int | None
    draws: bool
    code: str


class EnvironmentFailure(Exception):
    """What an environment has raised, or how its process has ended, in one line.

    Attributes:
        trace: the traceback, in the environment's process; "" where it just ended.
    """

    def __init__(self, message: str, trace: str = "") -> None:
        super().__init__(message)
        self.trace = trace


class EnvironmentProcess:
    """An environment that another process runs; every call waits for it.

    Args:
        id, kwargs: of `gymnasium.make`.

    Attributes:
        about: what it says of itself.

    Raises:
        EnvironmentFailure: from any call, what the environment raises, or that its process is gone.
    """

    def __init__(self, id: str, kwargs: Mapping[str, Any]) -> None:
        # No child of multiprocessing: workers of `lfr.jobs` are daemons, which may have none.
        self._pipe, other = Pipe()
        # A module beside params.yaml is found, as `python -m` finds it; the command `lfr` does not.
        paths = os.pathsep.join([*filter(None, sys.path), os.getcwd()])
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(other.fileno())],
            pass_fds=[other.fileno()], stdin=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": paths},
        )  # fmt: skip
        other.close()
        self._end = weakref.finalize(self, _ended, self._process, self._pipe)
        self.about: About = self._asked(id, dict(kwargs))

    def reset(self, seed: int) -> Any:
        """Begin the episode of a seed; what is observed."""
        return self._asked("reset", seed)

    def step(self, action: NDArray[Any]) -> tuple[Any, float, bool, dict[str, Any]]:
        """What is observed after an action, the reward, whether the episode is over, the info."""
        return self._asked("step", action)

    def render(self) -> NDArray[np.uint8]:
        """A picture (H, W, 3)."""
        return self._asked("render", None)

    def close(self) -> None:
        """End the process, as forgetting it would; nothing more can be asked."""
        self._end()

    def _asked(self, what: str, argument: Any) -> Any:
        with contextlib.suppress(OSError):  # of a process that has ended, which is told below
            self._pipe.send((what, argument))
        return self._answer()

    def _answer(self) -> Any:
        try:
            good, answer = self._pipe.recv()
        except (EOFError, OSError):
            code = self._process.wait()
            raise EnvironmentFailure(f"its process has ended, exit code {code}") from None
        if not good:
            raise EnvironmentFailure(*answer)
        return answer


def _ended(process: subprocess.Popen[bytes], pipe: Connection) -> None:
    pipe.close()
    try:
        process.wait(LAST)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _serve(pipe: Connection) -> None:
    """The other process: make the environment, then answer until there is nothing more to ask."""
    id, kwargs = pipe.recv()
    made: list[gymnasium.Env[Any, Any]] = []

    def make() -> About:
        made.append(gymnasium.make(id, **kwargs))
        return _about(made[0])

    with contextlib.suppress(EOFError, BrokenPipeError, KeyboardInterrupt):
        if not _answered(pipe, make):
            return
        while True:
            what, argument = pipe.recv()
            _answered(pipe, lambda what=what, argument=argument: _do(made[0], what, argument))
    if made:
        made[0].close()


def _answered(pipe: Connection, call: Callable[[], Any]) -> bool:
    try:
        pipe.send((True, call()))
    except Exception as error:  # whatever an environment of somebody's raises
        said = " ".join(str(error).split())
        pipe.send((False, (f"{type(error).__name__}: {said}", traceback.format_exc())))
        return False
    return True


def _about(environment: gymnasium.Env[Any, Any]) -> About:
    file = inspect.getsourcefile(type(environment.unwrapped))
    return About(
        environment.action_space,
        environment.spec.max_episode_steps if environment.spec else None,
        environment.render_mode == "rgb_array",
        file_hash(Path(file)) if file else "",
    )


def _do(environment: gymnasium.Env[Any, Any], what: str, argument: Any) -> Any:
    if what == "reset":
        return environment.reset(seed=argument)[0]
    if what == "render":
        return np.asarray(environment.render(), np.uint8)
    observed, reward, terminated, truncated, info = environment.step(argument)
    return observed, float(reward), bool(terminated or truncated), info


if __name__ == "__main__":
    # As `lfr.environments.process`, by whose name what it answers is found on the other side.
    from lfr.environments import process

    process._serve(Connection(int(sys.argv[1])))
