"""The errors a user can cause. Each is one line: what was found, what was expected, what to do."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


class LfrError(Exception):
    """A mistake that the reader of the message can mend; shown without a traceback."""

    exit_code = 2

    def __reduce__(self) -> tuple[object, ...]:
        """Pickles whatever the subclass's __init__ takes: jobs raise these in other processes."""
        return _revive, (type(self), self.args), self.__dict__


def _revive(cls: type[LfrError], args: tuple[object, ...]) -> LfrError:
    return cls.__new__(cls, *args)


class UnknownNameError(LfrError):
    """A name that is not among the valid ones, which the message lists."""

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        self.kind, self.name, self.valid = kind, name, tuple(valid)
        super().__init__(f"unknown {kind} {name!r}; valid: {', '.join(self.valid) or '(none)'}")


class ParameterError(LfrError):
    """A parameter that is missing, unknown, of the wrong type, or outside its range."""


class DataError(LfrError):
    """A file that is missing, cut off, or not what it should be.

    The message names all that is known of the place and of the difference:
    "wrong type: a.parquet, episode 3, column action, found float64, expected float32".
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path,
        episode: int | None = None,
        column: str | None = None,
        found: object = None,
        expected: object = None,
    ) -> None:
        self.message, self.file = message, Path(file)
        self.episode, self.column = episode, column
        self.found, self.expected = found, expected
        named = {"episode": episode, "column": column, "found": found, "expected": expected}
        details = [f"{name} {value}" for name, value in named.items() if value is not None]
        super().__init__(f"{message}: {', '.join([str(file), *details])}")


class MissingLibraryError(LfrError):
    """A library of the machine that is not installed; the message names the package to install."""
