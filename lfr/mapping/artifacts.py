"""G and F on disk, with what they have seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.artifacts import load_model, plain, save_model
from lfr.errors import DataError
from lfr.mapping.generator import Generator

KIND = "generator"
SHAPE = ("latent_dim", "hidden", "layers")


@dataclass(frozen=True)
class MappingSeen:
    """What G and F have learned from.

    Attributes:
        transfer: its name.
        source, target: the two arms; G leads from the source's latent space to the target's.
        tasks: the common tasks.
        datasets: dataset name -> SHA-256 of its rows, of both arms.
        seed: of the training.
    """

    transfer: str
    source: str
    target: str
    tasks: tuple[str, ...]
    datasets: dict[str, str]
    seed: int


def save_generator(folder: Path, generator: Generator, seen: MappingSeen) -> None:
    shape = {name: getattr(generator, name) for name in SHAPE}
    config = {"kind": KIND, "model": shape, "seen": plain(seen)}
    save_model(folder, config, generator.state_dict())


def load_generator(folder: Path) -> Generator:
    """G or F in a folder, ready to translate.

    Raises:
        DataError: the folder holds no generator, or a damaged one.
    """
    config, tensors = load_model(folder)
    if config.get("kind") != KIND:
        raise DataError(
            "another kind of model",
            file=folder / "config.json",
            found=config.get("kind"),
            expected=KIND,
        )
    generator = Generator(**config["model"])
    try:
        generator.load_state_dict(tensors)
    except RuntimeError as error:
        raise DataError(
            "the tensors do not fit the configuration",
            file=folder / "model.safetensors",
            found=str(error).splitlines()[-1].strip(),
        ) from None
    return generator.eval()


def load_mapping_seen(folder: Path) -> MappingSeen:
    """What the generator in a folder has learned from."""
    config, _ = load_model(folder)
    seen = config["seen"]
    return MappingSeen(**(seen | {"tasks": tuple(seen["tasks"])}))
