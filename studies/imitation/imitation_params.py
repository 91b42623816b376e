"""Parameters of BC+RNN."""

from __future__ import annotations

from dataclasses import dataclass

from lfr.errors import ParameterError


@dataclass(frozen=True)
class ImitationParams:
    """BC-RNN as robomimic sets it for low-dimensional human demonstrations.

    Source: ARISE-Initiative/robomimic, ``exps/templates/bc.json`` and
    ``scripts/generate_paper_configs.py``, which take the 1024 x 1024 layers between LSTM and output
    away. It trains for 200,000 updates at a constant rate; here fewer, at a rate that falls to 0
    along a cosine.
    """

    hidden: int = 400  # LSTM units per layer
    layers: int = 2
    horizon: int = 10  # control steps of a sequence, and between two resets of the hidden state
    modes: int = 5  # of the Gaussian mixture
    min_std: float = 1e-4  # added to the softplus
    batch: int = 100  # sequences
    updates: int = 4000  # about what six minutes of one core are enough for
    learning_rate: float = 1e-3  # at the start of the cosine

    def __post_init__(self) -> None:
        for name in ("hidden", "layers", "horizon", "modes", "batch", "updates"):
            if getattr(self, name) < 1:
                raise ParameterError(f"{name} must be at least 1, found {getattr(self, name)}")
        if self.min_std <= 0 or self.learning_rate <= 0:
            raise ParameterError(
                f"min_std and learning_rate must be above 0, "
                f"found {self.min_std} and {self.learning_rate}"
            )
