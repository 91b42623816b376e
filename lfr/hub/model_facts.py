"""What a folder of models says of itself, and what the stages noted of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import read_json
from lfr.embodiments import is_known
from lfr.errors import DataError

CONFIG, TENSORS = "config.json", "model.safetensors"
STAGES = {  # kind of model -> the stage that makes it
    "skill_vae": "skills",
    "skill_prior": "skills",
    "hand_jacobian": "skills",
    "generator": "mapping",
    "transferred_policy": "transfer",
}


@dataclass(frozen=True)
class Part:
    """One model in the folder; `place` is its path in there, "." for the folder itself."""

    place: str
    config: dict[str, Any]
    size: int

    @property
    def kind(self) -> str:
        return self.config["kind"]

    @property
    def seen(self) -> dict[str, Any]:
        """What it has learned from; a transferred policy says what it is about."""
        return self.config.get("seen") or self.config.get("about") or {}


@dataclass(frozen=True)
class ModelFacts:
    """The models of one folder.

    Attributes:
        name: of the robot whose skill models they are, or of the transfer, with the method where
            one was learned: "panda", "s1-panda-lift-lfr".
        stage: the stage that makes such models.
        folder: where they lie in this project, "models/skills/panda".
        parts: the models, in the order of their places.
        results: by stage, what the stages noted of them; empty where they noted nothing.
    """

    name: str
    stage: str
    folder: str
    parts: tuple[Part, ...]
    results: dict[str, dict[str, Any]]

    @property
    def title(self) -> str:
        return f"{self.stage}-{self.name}"


def model_folders(path: Path) -> list[Path]:
    """Folders at or below `path` that hold a model, without hidden ones."""
    found = (config.parent for config in sorted(path.rglob(CONFIG)))
    return [
        folder
        for folder in found
        if (folder / TENSORS).is_file()
        and not any(part.startswith(".") for part in folder.relative_to(path).parts)
    ]


def read_models(path: Path, results: Path) -> ModelFacts:
    """Read a folder of models, and what `results` holds of them.

    Raises:
        DataError: no models, models of several stages or of an unknown kind, or results that
            speak of other models.
    """
    path = Path(path)
    parts = tuple(
        Part(
            folder.relative_to(path).as_posix(),
            read_json(folder / CONFIG),
            (folder / TENSORS).stat().st_size,
        )
        for folder in model_folders(path)
    )
    if not parts:
        raise DataError(
            "neither a dataset nor models", file=path, found=f"no {CONFIG} with {TENSORS}"
        )
    kinds = sorted({str(part.config.get("kind")) for part in parts})
    stages = {STAGES.get(kind) for kind in kinds}
    stage = stages.pop()
    if stage is None or stages:
        raise DataError(
            "not the models of one stage",
            file=path,
            found=", ".join(kinds),
            expected=f"kinds of one of {', '.join(dict.fromkeys(STAGES.values()))}",
        )
    name, folder = _names(path, stage, parts)
    noted = _results(name, stage, results)
    _compare(parts, noted, results / stage / f"{name}.json")
    return ModelFacts(name, stage, folder, parts, noted)


def _names(path: Path, stage: str, parts: tuple[Part, ...]) -> tuple[str, str]:
    """The robot's or the transfer's name, and where its models lie in this project."""
    place = path.resolve()
    seen = parts[0].seen
    if stage == "transfer" and {"transfer", "method"} <= set(seen):
        name = f"{seen['transfer']}-{seen['method']}"
    else:
        name = seen.get("robot" if stage == "skills" else "transfer", place.name)
    inside = place.name if place.parent.name == name else ""
    external = stage == "skills" and not is_known(name)
    made_by = f"external-{stage}" if external else stage
    return name, "/".join(filter(None, ("models", made_by, name, inside)))


def _results(name: str, stage: str, results: Path) -> dict[str, dict[str, Any]]:
    files = {"skills": ("skills",), "mapping": ("mapping", "chain"),
             "transfer": ("transfer", "evaluate")}[stage]  # fmt: skip
    paths = {file: results / file / f"{name}.json" for file in files}
    return {file: read_json(path) for file, path in paths.items() if path.is_file()}


def _compare(parts: tuple[Part, ...], noted: dict[str, dict[str, Any]], file: Path) -> None:
    """Hold the results to the demonstrations that the models have seen.

    Raises:
        DataError: they are of other datasets.
    """
    known: dict[str, str] = dict(noted.get("transfer", {}).get("datasets", {}))
    for model in noted.get("skills", {}).get("models", {}).values():
        known |= model["datasets"]
    for part in parts:
        for dataset, digest in part.seen.get("datasets", {}).items():
            if known.get(dataset, digest) != digest:
                raise DataError(
                    f"the results are of other models than {part.place}; run `dvc repro`",
                    file=file,
                    column=dataset,
                    found=known[dataset][:12],
                    expected=digest[:12],
                )
