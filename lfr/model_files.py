"""Networks on disk, each with what it takes to build it again and what it has learned from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import as_json, load_model, save_model
from lfr.errors import DataError
from lfr.records import from_mapping

if TYPE_CHECKING:
    from _typeshed import DataclassInstance
    from torch import Tensor, nn


@dataclass(frozen=True)
class ModelKind[Model: nn.Module]:
    """Models of one class, each a folder of ``config.json`` and ``model.safetensors``.

    Attributes:
        name: what ``config.json`` calls them, so that no model is taken for one of another kind.
        network: their class.
        shape: the names of its constructor's arguments, which are names of its attributes too.
    """

    name: str
    network: type[Model]
    shape: tuple[str, ...]

    def save(self, folder: Path, model: Model, seen: object) -> None:
        """Write a model whole, with what it has seen (a dataclass)."""
        config = {"kind": self.name, "model": self.shape_of(model), "seen": as_json(seen)}
        save_model(folder, config, model.state_dict())

    def load(self, folder: Path) -> Model:
        """The model in a folder, ready to be used.

        Raises:
            DataError: the folder holds no model of this kind, or a damaged one.
        """
        config, tensors = read_model(folder, self.name)
        return self.build(config["model"], tensors, folder)

    def shape_of(self, model: Model) -> dict[str, Any]:
        """The constructor's arguments that gave ``model``, as JSON holds them."""
        return {name: as_json(getattr(model, name)) for name in self.shape}

    def build(self, shape: dict[str, Any], tensors: dict[str, Tensor], folder: Path) -> Model:
        """A model of this shape with these tensors, ready to be used.

        Raises:
            DataError: the tensors, which come from ``folder``, are not those of such a model.
        """
        model = self.network(**shape)
        try:
            model.load_state_dict(tensors)
        except RuntimeError as error:
            raise DataError(
                "the tensors do not fit the configuration",
                file=folder / "model.safetensors",
                found=str(error).splitlines()[-1].strip(),
            ) from None
        return model.eval()


def read_model(folder: Path, kind: str) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """What ``config.json`` says, and the tensors.

    Raises:
        DataError: the folder holds no model of this kind, or a damaged one.
    """
    config, tensors = load_model(folder)
    if config.get("kind") != kind:
        raise DataError(
            "another kind of model",
            file=folder / "config.json",
            found=config.get("kind"),
            expected=kind,
        )
    return config, tensors


def load_seen_as[Seen: DataclassInstance](
    seen: type[Seen], folder: Path, kind: ModelKind | None = None
) -> Seen:
    """What the model in a folder has learned from, as a dataclass; ``kind`` None takes any.

    Raises:
        DataError: the folder holds no model of this kind, or a damaged one.
    """
    config, _ = load_model(folder) if kind is None else read_model(folder, kind.name)
    return from_mapping(seen, config["seen"], str(folder / "config.json"))
