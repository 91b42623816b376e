"""Which choice carries a link: one set back, or one kept, beside all of them and none."""

from __future__ import annotations

from pathlib import Path

from lfr.evaluation.evidence.parts import PARTS, parts_section
from lfr.evaluation.evidence.records import STAGES, read_evidence
from lfr.evaluation.evidence.report import report
from pipeline.paper import _choices
from tests.evaluation.evidence.made_up import zero_shot
from tests.evaluation.evidence.test_evidence import CAN, cells

LINKS = {"own_arm": [98, 97], "identity": [99, 100], "mapped": [90, 92]}


def made(folder: Path, part: str, **changed: list[int]) -> None:
    zero_shot(folder, CAN, LINKS | changed, "plain_parts", part)


def some(folder: Path) -> None:
    """Ours and plain, two parts alone, one kept; ours have a third seed."""
    zero_shot(folder, CAN, {link: [*found, 0] for link, found in LINKS.items()})
    zero_shot(folder, CAN, {"own_arm": [97, 97], "identity": [12, 14], "mapped": [0, 0]}, "plain")
    made(folder, "demonstrations", identity=[50, 52], mapped=[1, 0])
    made(folder, "vae", mapped=[40, 44])
    made(folder, "all_but_demonstrations", identity=[95, 94], mapped=[0, 1])


def test_a_row_for_each_set_of_choices_from_ours_to_plain(tmp_path: Path) -> None:
    some(tmp_path)
    section = parts_section(read_evidence(tmp_path)) or ""
    names = [line.split("|")[1].strip() for line in section.splitlines() if line.startswith("|")]
    parts = ["demonstrations undisturbed", "the VAE's", "all but demonstrations undisturbed"]
    assert names[2:] == ["nothing", *parts, "all"]
    (ours,), (demonstrations,), (plain,) = (
        cells(section, name) for name in ("nothing", parts[0], "all")
    )
    assert ours[2].startswith("99.5 [")  # identity; not 66.3, of the third seed too
    assert ours[2].endswith("] (99, 100)")
    assert demonstrations[3].endswith("] (1, 0)")
    assert plain[2].endswith("] (12, 14)")


def test_which_one_takes_it_down_and_which_brings_it_back(tmp_path: Path) -> None:
    some(tmp_path)
    said = (parts_section(read_evidence(tmp_path)) or "").rstrip().splitlines()[-1]
    falls, rises = "falls where one is set back alone:", "rises where one alone is not set back:"
    assert said == (
        f"`identity` {falls} demonstrations undisturbed (99.5 to 51.0). "
        f"`identity` {rises} demonstrations undisturbed (13.0 to 94.5). "
        f"`mapped` {falls} demonstrations undisturbed (91.0 to 0.5), the VAE's (91.0 to 42.0). "
        f"`mapped` {rises} none of 1."
    )


def test_nothing_to_compare_with_says_nothing(tmp_path: Path) -> None:
    made(tmp_path, "vae")
    evidence = read_evidence(tmp_path)
    section = parts_section(evidence) or ""
    assert "falls" not in section
    assert cells(section, "nothing")[0][1:] == ["-"] * 3
    assert section.strip() in report(evidence)
    assert parts_section(read_evidence(tmp_path / "none")) is None


def test_the_parts_are_the_stages() -> None:
    assert tuple(PARTS) == _choices.PARTS
    assert "plain_parts" in STAGES
