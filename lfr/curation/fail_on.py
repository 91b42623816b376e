"""Which findings make `lfr verify` fail."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lfr.curation.finding import Finding
from lfr.curation.kinds import KINDS
from lfr.errors import UnknownNameError

SEVERITIES = {"error": {"error"}, "warning": {"error", "warning"}, "none": set[str]()}


@dataclass(frozen=True)
class FailOn:
    """`error`, `warning` (and errors), `none`, or kinds: what `--fail-on` takes.

    Attributes:
        severities: any finding that is so bad fails.
        kinds: any finding of these fails, however bad.
    """

    severities: frozenset[str]
    kinds: frozenset[str] = frozenset()

    @classmethod
    def parse(cls, text: str) -> FailOn:
        """Words with commas between them.

        Raises:
            UnknownNameError: a word that is none of these.
        """
        words = [word.strip() for word in text.split(",")]
        for word in words:
            if word not in SEVERITIES and word not in KINDS:
                raise UnknownNameError("--fail-on", word, (*SEVERITIES, *KINDS))
        severities = frozenset[str]().union(*(SEVERITIES.get(word, ()) for word in words))
        return cls(severities, frozenset(words) & KINDS.keys())

    def fails(self, findings: Iterable[Finding]) -> bool:
        """Whether there is such a finding."""
        return any(f.severity in self.severities or f.check in self.kinds for f in findings)
