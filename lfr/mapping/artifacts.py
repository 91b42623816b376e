"""G and F on disk, with what they have seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.mapping.generator import Generator
from lfr.params import from_mapping
from lfr.skills.artifacts import load_kind, restored, save_kind

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
    save_kind(folder, KIND, {name: getattr(generator, name) for name in SHAPE}, generator, seen)


def load_generator(folder: Path) -> Generator:
    """G or F in a folder, ready to translate.

    Raises:
        DataError: the folder holds no generator, or a damaged one.
    """
    shape, _, tensors = load_kind(folder, KIND)
    return restored(Generator(**shape), tensors, folder)


def load_mapping_seen(folder: Path) -> MappingSeen:
    """What the generator in a folder has learned from."""
    _, seen, _ = load_kind(folder, KIND)
    return from_mapping(MappingSeen, seen, str(folder / "config.json"))
