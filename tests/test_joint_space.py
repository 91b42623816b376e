"""What docs/joint-space.md shows of the trials is what their tables hold."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from benchmarks._figures import shown

ROOT = Path(__file__).parent.parent
PAGE, STUDIES = ROOT / "docs" / "joint-space.md", ROOT / "results" / "studies"
Row = dict[str, str]


def table(name: str) -> list[Row]:
    header, _, *lines = shown(PAGE, name).strip().splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in (header, *lines)]
    return [dict(zip(cells[0], row, strict=True)) for row in cells[1:]]


def rows(name: str) -> list[Row]:
    with (STUDIES / f"joint_space_{name}.csv").open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def percent(found: list[Row], column: str = "successes") -> str:
    """Of all starts of these rows; a dash without any."""
    starts = sum(int(row["starts"]) for row in found)
    return f"{100 * sum(int(row[column]) for row in found) / starts:.0f}" if starts else "-"


@pytest.mark.parametrize("line", table("first link"), ids=lambda line: " ".join(line.values()))
def test_the_first_link(line: Row) -> None:
    said = {"no": "0", "yes": "1"}
    wanted = {
        "prior_of": "skills", "arm": line["arm"], "task": line["task"],
        "demonstrations": line["demonstrations"],
        "azimuth_frame": said[line["azimuth frame"]], "latent_dim": line["latent"],
        "alpha": {"16": "0.0001", "32": "1e-05"}[line["latent"]],
        "loss_at_hand": said[line["loss at the hand"]],
        "vae_sees_joints": said[line["VAE sees the joints"]], "prior_sees_joints": "0",
        "carried_out": "5", "prior_steps": "6000", "augment": "0.5", "input_noise": "0.1",
    }  # fmt: skip
    found = [row for row in rows("first_link") if wanted.items() <= row.items()]
    assert found
    assert line["success"] == percent(found)


@pytest.mark.parametrize("line", table("mapping"), ids=lambda line: " ".join(line.values()))
def test_the_mapping(line: Row) -> None:
    ends = {key: line[key] for key in ("source", "target", "task")}
    links = [
        row for row in rows("links")
        if ends.items() <= row.items() and row["vae_sees_joints_and_loss_at_hand"] == "0"
    ]  # fmt: skip
    for link in ("own arm", "oracle"):
        assert line[link] == percent(links, link.replace(" ", "_"))
    untranslated = [row for row in links if row["no_generator"]]
    assert line["no generator"] == percent(untranslated, "no_generator")
    plain = {"vae_sees_joints": "0", "recombined": "0.0", "averaged": "1"} | ends
    known = [row for row in rows("mapping") if plain.items() <= row.items()]
    maps = {"linear in k": ("linear", "k"), "linear in (k, s)": ("linear", "k,s"),
            "G(k)": ("network", "k"), "G(k, s)": ("network", "k,s")}  # fmt: skip
    for name, (kind, sees) in maps.items():
        found = [row for row in known if (row["map"], row["sees"]) == (kind, sees)]
        assert line[name] == percent(found), name


@pytest.mark.parametrize("line", table("chain"), ids=lambda line: " ".join(line.values()))
def test_the_chain(line: Row) -> None:
    ends = {key: line[key] for key in ("source", "target", "task", "demonstrations")}
    for link in ("identity", "no_generator", "linear", "mapped", "retarget", "after_learning"):
        found = [row for row in rows("chain") if (ends | {"link": link}).items() <= row.items()]
        if link != "retarget":  # of the pipeline's starts, not of the 40 others
            found = [row for row in found if row["starts"] == "100"]
        assert line[link.replace("_", " ")] == percent(found), link


@pytest.mark.parametrize("line", table("own arm"), ids=lambda line: " ".join(line.values()))
def test_own_arm(line: Row) -> None:
    for task in ("lift", "stack", "pick_place", "nut_assembly"):
        of = {"arm": line["arm"], "demonstrations": line["demonstrations"], "task": task}
        assert line[task] == percent([row for row in rows("own_arm") if of.items() <= row.items()])


@pytest.mark.parametrize("line", table("starts"), ids=lambda line: line["drift"])
def test_where_the_can_is_lost(line: Row) -> None:
    for link in ("own_arm", "retarget", "mapped"):
        found = [
            row for row in rows("starts")
            if line["drift"] == f"{row['drift_steps']} steps at {row['drift_speed']}"
            and row["link"] == link
        ]  # fmt: skip
        assert line[link.replace("_", " ")] == percent(found)
