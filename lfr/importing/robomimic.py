"""robomimic's HDF5 files, read and held to their layout.

The layout is that of robomimic's documentation ("Dataset Structure"): `data/demo_N` with `actions`,
`rewards`, `dones`, `states` and a group `obs`, the attributes `num_samples` and, from robosuite,
`model_file`; the attribute `env_args` of `data` in JSON; and `mask`, lists of demonstrations by
name. Row t of `obs` was seen before action t, and `rewards` and `dones` came of it.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.errors import DataError

EXTRACT = "robomimic's dataset_states_to_obs.py adds observations, rewards and dones to raw files"


@dataclass(frozen=True)
class Demo:
    """One demonstration of T frames.

    Attributes:
        name: of its group, such as "demo_7".
        file: the HDF5 file, for messages.
        group: the open group.
    """

    name: str
    file: Path
    group: Any

    def __len__(self) -> int:
        return len(self._found("actions") if "actions" in self.group else self.array("actions"))

    @property
    def observations(self) -> dict[str, tuple[int, ...]]:
        """Shape of a frame of each observation: `object` -> (10,)."""
        group = self.group.get("obs", {})
        return {key: tuple(self._found(f"obs/{key}").shape[1:]) for key in group}

    def array(self, key: str) -> NDArray:
        """A whole array of the demonstration, such as "actions" or "obs/object".

        Raises:
            DataError: it is not there, or has a value that is not finite.
        """
        if key not in self.group:
            folder, _, _ = key.rpartition("/")
            there = self.group.get(folder, self.group)
            expected = key if key in ("actions", "states") else f"{key}; {EXTRACT}"
            raise DataError(
                "an array is missing", file=self.file, column=f"{self.name}/{key}",
                found=", ".join(there) or "none", expected=expected,
            )  # fmt: skip
        values = self._found(key)[()]
        if values.dtype.kind == "f":
            bad = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
            if bad.any():
                raise DataError(
                    "a value that is not finite", file=self.file, column=f"{self.name}/{key}",
                    found=f"{np.ravel(values[bad][0]).tolist()} in frame {bad.argmax()}",
                    expected="finite numbers",
                )  # fmt: skip
        return values

    def vectors(self, key: str) -> NDArray:
        """An array (T, D) with a row for each action; raises DataError as `frames`, or else."""
        values = self.frames(key)
        if values.ndim != 2:
            raise DataError("no array of vectors", file=self.file, column=f"{self.name}/{key}",
                            found=values.shape, expected="(frames, dimensions)")  # fmt: skip
        return values

    def _found(self, key: str) -> Any:
        """An open array.

        Raises:
            DataError: it is behind a link to what is not there, or no array at all.
        """
        try:
            found = self.group[key]
            if not found.shape:
                raise AttributeError("a single value" if found.shape == () else "no array")
        except (KeyError, OSError, AttributeError) as error:
            raise DataError("no array that can be read", file=self.file,
                            column=f"{self.name}/{key}", found=str(error).strip("'\""),
                            expected="an array with a row for each action") from None  # fmt: skip
        return found

    def frames(self, key: str) -> NDArray:
        """An array with a row for each action.

        Raises:
            DataError: as `array`, or there are more or fewer rows.
        """
        values = self.array(key)
        if len(values) != len(self):
            raise DataError(
                "another number of rows than there are actions", file=self.file,
                column=f"{self.name}/{key}", found=len(values), expected=len(self),
            )  # fmt: skip
        return values

    def check_length(self) -> None:
        """Raises DataError when there are no actions, or not as many as `num_samples` says."""
        said = int(self.group.attrs.get("num_samples", len(self)))
        if said != len(self) or not said:
            raise DataError(
                "another number of actions than num_samples says; was the file cut off?",
                file=self.file, column=f"{self.name}/actions", found=len(self),
                expected=said or "at least 1",
            )  # fmt: skip

    @property
    def model_sha256(self) -> str | None:
        """SHA-256 of the MJCF model of its scene, where the file has it."""
        model = self.group.attrs.get("model_file")
        return None if model is None else hashlib.sha256(_text(model).encode()).hexdigest()

    @property
    def instruction(self) -> str | None:
        """The task in words, where the demonstration's `ep_meta` has it (`lang`)."""
        return json.loads(_text(self.group.attrs.get("ep_meta", "{}"))).get("lang")


@dataclass(frozen=True)
class RobomimicFile:
    """An open robomimic file."""

    path: Path
    root: Any

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The demonstrations, in the order of their numbers.

        Raises:
            DataError: there are none.
        """
        data = self.root.get("data", {})
        names = [name for name in data if hasattr(self._demonstration(name), "keys")]
        if not names:
            raise DataError(
                "not a robomimic file", file=self.path, column="data",
                found=", ".join(self.root) or "nothing", expected="groups demo_0, demo_1, ...",
            )  # fmt: skip
        return tuple(sorted(names, key=_number))

    def _demonstration(self, name: str) -> Any:
        try:
            return self.root["data"][name]
        except (KeyError, OSError) as error:  # a link to a file that is not there
            raise DataError("a demonstration that cannot be read", file=self.path,
                            column=f"data/{name}", found=str(error)) from None  # fmt: skip

    @cached_property
    def env_args(self) -> dict[str, Any]:
        """What `env_args` says of the environment: `env_name`, `env_kwargs`; {} without it."""
        try:
            return json.loads(_text(self.root["data"].attrs.get("env_args", "{}")))
        except json.JSONDecodeError as error:
            raise DataError(
                "not JSON", file=self.path, column="data.attrs['env_args']", found=error
            ) from None

    @cached_property
    def masks(self) -> dict[str, tuple[str, ...]]:
        """The filter keys: mask -> its demonstrations."""
        group = self.root.get("mask", {})
        return {name: tuple(_text(demo) for demo in group[name][()]) for name in group}

    def demo(self, name: str) -> Demo:
        return Demo(name, self.path, self.root["data"][name])

    def chosen(self, mask: str | None) -> Sequence[str]:
        """The demonstrations of a mask, or all.

        Raises:
            DataError: there is no such mask, or no demonstration in it.
        """
        if mask is None:
            return self.names
        if mask not in self.masks:
            raise DataError(
                "no such mask", file=self.path, column=f"mask/{mask}",
                found=", ".join(self.masks) or "no masks", expected=mask,
            )  # fmt: skip
        chosen = [name for name in self.names if name in self.masks[mask]]
        if not chosen:
            raise DataError("a mask without demonstrations", file=self.path, column=f"mask/{mask}")
        return chosen


@contextmanager
def open_robomimic(path: Path) -> Iterator[RobomimicFile]:
    """Open a robomimic file for reading.

    Raises:
        DataError: it is missing, cut off, or no HDF5 file.
    """
    import h5py

    if not path.is_file():
        raise DataError("the file is missing", file=path)
    try:
        root = h5py.File(path, "r")
    except OSError as error:
        raise DataError("cut off, or no HDF5 file", file=path, found=error) from error
    with root:
        yield RobomimicFile(path, root)


def _number(name: str) -> tuple[int, str]:
    digits = re.search(r"\d+$", name)
    return (int(digits.group()) if digits else -1, name)


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
