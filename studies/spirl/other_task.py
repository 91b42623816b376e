"""A skill prior asked about another task's observation: what is meant alike is put in its place."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor, nn

from lfr.model_files import ModelKind
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen


class OtherTaskPrior(nn.Module):
    """Maps observations (B, D) of a task to the ``(mu, log_sigma)`` (B, Z) of another's prior.

    An input of the inner prior that the task has no counterpart of is given the mean of the inner
    prior's demonstrations. The inner prior learns like any other network.

    Attributes:
        layout_names: of the observations that this prior is given.
        inner: the other task's prior.
        columns: for each of the inner prior's inputs its place in ``layout_names``, or -1.
    """

    places: Tensor

    def __init__(
        self,
        layout_names: Sequence[str],
        inner_names: Sequence[str],
        columns: Sequence[int],
        latent_dim: int,
        hidden: int,
        layers: int,
        turned: bool = False,
    ) -> None:
        super().__init__()
        self.turned = turned
        self.layout_names, self.inner_names = tuple(layout_names), tuple(inner_names)
        self.columns, self.latent_dim = tuple(columns), latent_dim
        self.hidden, self.layers = hidden, layers
        self.inner = SkillPrior(inner_names, latent_dim, hidden, layers, turned)
        places = places_of(self.columns, len(self.layout_names))
        self.register_buffer("places", places, persistent=False)

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        return self.inner(self.asked(observations))

    def asked(self, observations: Tensor) -> Tensor:
        """What the inner prior is asked about, in its own layout, for observations (B, D)."""
        return in_places(observations, self.inner.normalizer.mean, self.places)


def places_of(columns: Sequence[int], size: int) -> Tensor:
    """Where an inner prior's inputs stand in an observation of ``size`` with its means behind."""
    return torch.tensor([size + place if c < 0 else c for place, c in enumerate(columns)])


def in_places(observations: Tensor, means: Tensor, places: Tensor) -> Tensor:
    """The inner prior's inputs (B, I) in observations (B, D), and its means (I,) for the rest."""
    means = means.expand(len(observations), -1)
    return torch.cat([observations, means], dim=-1)[:, places]


OTHER_TASK = ModelKind(
    "other_task_prior",
    OtherTaskPrior,
    ("layout_names", "inner_names", "columns", "latent_dim", "hidden", "layers", "turned"),
)


def asked_about(
    inner: SkillPrior, inner_object: str, layout_names: Sequence[str], manipulated: str
) -> OtherTaskPrior:
    """A prior's copy, asked about observations called ``layout_names``.

    Args:
        inner_object, manipulated: the manipulated object's name in either layout: the first of
            `lfr.tasks.Task.objects`.
    """
    columns = counterparts(inner.layout_names, inner_object, layout_names, manipulated)
    prior = OtherTaskPrior(
        layout_names, inner.layout_names, columns, inner.latent_dim, inner.hidden, inner.layers,
        inner.turned,
    )  # fmt: skip
    prior.inner.load_state_dict(inner.state_dict())
    return prior.eval()


def counterparts(
    inner_names: Sequence[str], inner_object: str, names: Sequence[str], manipulated: str
) -> tuple[int, ...]:
    """For each of ``inner_names`` the place in ``names`` of what means the same, or -1.

    The manipulated objects correspond, so do their goals; all else if it is called alike.
    """
    there = {meaning(name, manipulated): place for place, name in enumerate(names)}
    return tuple(there.get(meaning(name, inner_object), -1) for name in inner_names)


def meaning(name: str, manipulated: str) -> str:
    """A dimension's name with `object` and `goal` for what a task calls these."""
    group, _, part = name.partition(".")
    start, leads, end = group.partition("_to_")
    if leads and start == manipulated:
        return f"object_to_goal.{part}"
    if leads and end == manipulated:
        return f"{start}_to_object.{part}"
    thing, _, form = group.rpartition("_")
    return f"object_{form}.{part}" if thing == manipulated else name


def save_other_task(folder: Path, prior: OtherTaskPrior, seen: Seen) -> None:
    OTHER_TASK.save(folder, prior, seen)


def load_other_task(folder: Path) -> OtherTaskPrior:
    """Raises DataError where the folder holds no such prior, or a damaged one."""
    return OTHER_TASK.load(folder)
