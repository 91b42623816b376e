"""A learning run that kills itself at 80 environment steps; run by test_loop.py."""

import os
import signal
import sys
from pathlib import Path

import torch

from lfr.transfer.loop import TransferLoop
from lfr.transfer.observer import Observer

from .point import PointSimulation, lfr_initialization, point_models, point_params


class Kill(Observer):
    def on_progress(self, env_steps: int, total: int) -> None:
        if env_steps >= 80:
            os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    torch.set_num_threads(1)
    params = point_params()
    start = lfr_initialization(point_models(), params)
    simulations = [PointSimulation() for _ in range(params.simulations)]
    TransferLoop(start, simulations, params, 0, Path(sys.argv[1]), Kill()).run()
