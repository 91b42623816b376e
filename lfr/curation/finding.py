"""What a check found: where, what was there, what was expected, and how bad it is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

from lfr.artifacts import as_json
from lfr.errors import DataError

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a dataset.

    Attributes:
        check: the name of the kind, e.g. `gap-in-time`; see docs/trust.md.
        message: what is wrong, in words.
        severity: an "error" makes the dataset unfit; a "warning" is for someone to look at.
        file: relative to the dataset's folder, "" where no one file is at fault.
        episode: its index; None where it is not about one.
        column: a column of the rows, of meta/episodes or of stats.json, or one dimension of it.
        row: over the rows of all episodes; with `places` above 1, the first of them.
        frames: of the episode, the first and the last that it is about; None where it is not about
            some.
        found, expected: what was there, and what should be.
        places: how many rows or episodes the same is wrong in.
        episodes: all that it is about, from the lowest; none where it is about the whole dataset.
    """

    check: str
    message: str
    severity: Severity = "error"
    file: str = ""
    episode: int | None = None
    column: str | None = None
    row: int | None = None
    found: Any = None
    expected: Any = None
    places: int = 1
    frames: tuple[int, int] | None = None
    episodes: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.episode is not None and not self.episodes:
            object.__setattr__(self, "episodes", (self.episode,))

    def __str__(self) -> str:
        """One line for a terminal."""
        where = [short(self.file)] if self.file else []
        named = {"episode": self.episode, "column": self.column or None, "row": self.row}
        if self.frames is not None:
            named |= {"row": None, "frames": "{} to {}".format(*self.frames)}
        named |= {"found": self.found, "expected": self.expected}
        where += [f"{name} {short(value)}" for name, value in named.items() if value is not None]
        more = f" (and {self.places - 1} more)" if self.places > 1 else ""
        return f"{self.severity}: {self.check}: {self.message}: {', '.join(where)}{more}"

    def as_json(self) -> dict[str, Any]:
        """For machines: every attribute, in JSON's types."""
        content = as_json(self)
        for name in ("found", "expected"):  # JSON has no NaN
            value = getattr(self, name)
            if value is not None and not isinstance(value, bool | int | str):
                content[name] = short(value)
        return content

    @classmethod
    def from_json(cls, content: Any, file: Path) -> Finding:
        """What `as_json` gave.

        Args:
            file: that it stood in, for the error.

        Raises:
            DataError: it is no finding.
        """
        values = content if isinstance(content, dict) else {}
        episodes, frames = values.get("episodes") or (), values.get("frames")
        sound = (
            isinstance(values.get("check"), str)
            and values.get("severity") in get_args(Severity)
            and all(isinstance(values.get(name, ""), str) for name in ("message", "file"))
            and isinstance(values.get("column"), str | None)
            and all(type(values.get(name, 0)) is int for name in ("places", "row", "episode")
                    if name == "places" or values.get(name) is not None)
            and isinstance(episodes, list | tuple)
            and all(type(episode) is int for episode in episodes)
            and (frames is None or (isinstance(frames, list) and len(frames) == 2
                                    and all(type(frame) is int for frame in frames)))
        )  # fmt: skip
        if not sound:
            raise DataError("holds what is no finding", file=file, found=short(content),
                            expected="what lfr verify --json prints")  # fmt: skip
        known = {field.name: values[field.name] for field in fields(cls) if field.name in values}
        known |= {"episodes": tuple(episodes), "frames": tuple(frames) if frames else None}
        return cls(**{"message": "", **known})


def short(value: object) -> str:
    """A value on a line of at most 200 letters, none of which a terminal obeys."""
    text = f"{value:.9g}" if isinstance(value, float) else str(value)
    text = " ".join(text.split())
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
    return text if len(text) <= 200 else f"{text[:197]}..."


class Unreadable(Exception):
    """A part of the dataset that a check needs and cannot have; the finding says why."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(str(finding))
        self.finding = finding


@contextmanager
def unreadable(check: str, message: str, *errors: type[Exception], **place: Any) -> Iterator[None]:
    """Turn these errors into a finding at this place."""
    try:
        yield
    except errors as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise Unreadable(Finding(check, message, found=text, **place)) from error


def as_error(dataset: Path, finding: Finding, message: str = "") -> DataError:
    """A finding of the dataset in this folder as an error, by default in its own words."""
    return DataError(
        message or finding.message,
        file=dataset / finding.file,
        episode=finding.episode,
        column=finding.column,
        found=finding.found,
        expected=finding.expected,
    )


@contextmanager
def readable(dataset: Path) -> Iterator[None]:
    """Turn what cannot be read of the dataset in this folder into a DataError."""
    try:
        yield
    except Unreadable as unreadable:
        raise as_error(dataset, unreadable.finding) from None


def first(wrong: Any) -> tuple[int, int]:
    """Index of the first true value of a (N,) bool array, and how many there are."""
    return int(wrong.argmax()), int(wrong.sum())
