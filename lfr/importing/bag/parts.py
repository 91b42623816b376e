"""A part of a feature, read from one message after the other by the names of its numbers."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from lfr.importing.bag.decoding import MessageError
from lfr.importing.bag.mapping import Part
from lfr.importing.bag.values import names_at, numbers

Names = tuple[str, ...]


@dataclass
class PartReader:
    """Reads a part's numbers, always the same ones in the same order.

    Attributes:
        part: what the mapping says of it.
        names: of the numbers as messages call them, or as they are called here where messages do
            not name them; None until a message was seen.
        named: messages name their numbers: joints, or the fields of a message.
        joints: they do so by a list beside the numbers, which each message may have another of.
        met: each list of names that messages had.
    """

    part: Part
    names: Names | None = None
    named: bool = False
    joints: bool = False
    met: dict[Names, list[int] | None] = field(default_factory=dict)

    def learn(self, message: Any) -> None:
        """Take the names, as far as the mapping does not say them, from a first message.

        Raises:
            MessageError: it does not hold what the mapping says; or its numbers have no names and
                are more or fewer than the names of the mapping.
        """
        names, values = numbers(message, self.part.field)
        self.named = names is not None
        self.joints = self.named and names == names_at(message, self.part.field)
        label = self._label()
        counted = (
            (label,) if len(values) == 1 else tuple(f"{label}.{i}" for i in range(len(values)))
        )
        said = self.part.names
        if not self.named and said is not None and len(said) != len(values):
            raise MessageError(f"{len(values)} numbers without names, {len(said)} names in the "
                               "mapping")  # fmt: skip
        self.names = said or names or counted

    def is_others(self, message: Any) -> bool:
        """Whether a message is of another publisher on the topic, with none of the joints.

        Raises:
            MessageError: it does not hold what the mapping says.
        """
        names = names_at(message, self.part.field)
        return names is not None and self._places(names) is None

    def read(self, message: Any) -> list[float]:
        """The numbers of a message.

        Raises:
            MessageError: it does not hold what the mapping says, or a joint is missing.
        """
        names, values = numbers(message, self.part.field)
        assert self.names is not None
        if names is None:
            if self.named or len(values) != len(self.names):
                raise MessageError(f"{len(values)} numbers without names; expected "
                                   f"{', '.join(self.names)}")  # fmt: skip
            return values
        places = self._places(names) if self.named else None
        if places is None or len(places) < len(self.names):
            missing = [name for name in self.names if name not in names]
            raise MessageError(f"no {', '.join(missing)} among {', '.join(names)}")
        return [values[place] for place in places]

    def missing(self) -> tuple[Names, bool]:
        """The names that no message had, or else, and then True, those that none had together."""
        assert self.names is not None
        if not self.joints or any(len(p or ()) == len(self.names) for p in self.met.values()):
            return (), False
        everywhere = {name for names in self.met for name in names}
        lost = tuple(name for name in self.names if name not in everywhere)
        return (lost, False) if lost else (self.names, True)

    @property
    def dimensions(self) -> Names:
        """What the numbers are called in the dataset."""
        return tuple(self.part.prefix + name for name in self.names or ())

    def _places(self, names: Names) -> list[int] | None:
        """Where the numbers are among these names; None where none of them is."""
        if names not in self.met:
            if len(set(names)) < len(names):
                raise MessageError(f"a name twice: {', '.join(names)}")
            assert self.names is not None
            self.met[names] = [names.index(n) for n in self.names if n in names] or None
        return self.met[names]

    def _label(self) -> str:
        """`position` by its path; `gripper_width` by its topic, where the path says nothing."""
        last = self.part.field.rpartition(".")[2]
        words = self.part.topic if last in ("", "data") else last
        return re.sub(r"\W+", "_", words).strip("_") or "number"
