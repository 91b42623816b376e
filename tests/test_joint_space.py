"""What docs/joint-space.md shows of the trials is what their tables hold."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from lfr.evaluation.marked import shown

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


MAPS = {
    "linear": {"map": "linear"},
    "Eq. 4 alone": {"map": "network", "hand_weight": "0.0", "sees": "k,s"},
    "with L_hand": {"sees": "k,s", "new_task": "1", "recombined": "0.5"},
    "G(k)": {"sees": "k", "new_task": "1", "recombined": "0.5"},
    "without the new task": {"sees": "k,s", "new_task": "0", "recombined": "0.5"},
    "not recombined": {"sees": "k,s", "new_task": "1", "recombined": "0.0"},
    "retarget": {"map": "retarget"},
    "oracle": {"map": "oracle"},
}
"""What a column of the table of L_hand is of; without a weight, that of the main job."""


@pytest.mark.parametrize("line", table("hand loss"), ids=lambda line: " ".join(line.values()))
def test_what_l_hand_brings(line: Row) -> None:
    ends = {key: line[key] for key in ("source", "target", "task")}
    for column, of in MAPS.items():
        wanted = ends | of
        if "sees" in of and "hand_weight" not in of:
            wanted |= {"map": "network", "hand_weight": "1000.0"}
        found = [row for row in rows("hand_loss") if wanted.items() <= row.items()]
        assert line[column] == percent(found), column
    assert line["with L_hand"] != "-"


def test_what_l_hand_brings_the_papers_g() -> None:
    """The two rates in the text."""
    of = {"task": "pick_place", "sees": "k", "hidden": "128", "steps_compared": "10"}
    known = [row for row in rows("hand_tuning") if of.items() <= row.items()]
    by_weight = [percent([row for row in known if row["hand_weight"] == weight])
                 for weight in ("0", "100")]  # fmt: skip
    assert "the units had {} % there without it and {} % with it".format(*by_weight) in (
        PAGE.read_text(encoding="utf-8")
    )


@pytest.mark.parametrize("line", table("own arm"), ids=lambda line: " ".join(line.values()))
def test_own_arm(line: Row) -> None:
    seen = {"no": "0", "yes": "1"}[line["pose and hand"]]
    for task in ("lift", "stack", "pick_place", "nut_assembly"):
        of = {"arm": line["arm"], "demonstrations": line["demonstrations"], "task": task,
              "vae_sees_pose": seen, "error_at_hand": seen}  # fmt: skip
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


COPIES = {
    "none": {"shift_m": "0.0", "mirror": "0"},
    "mirrored": {"shift_m": "0.0", "mirror": "1"},
    "shifted by 0.1 m, mirrored": {"shift_m": "0.1", "mirror": "1"},
    "shifted by 0.2 m, mirrored": {"shift_m": "0.2", "mirror": "1"},
}


@pytest.mark.parametrize("line", table("coverage"), ids=lambda line: " ".join(line.values()))
def test_where_sawyers_stack_is_lost(line: Row) -> None:
    wanted = {
        "task": line["task"], "demonstrations": line["demonstrations"],
        "drift_steps": line["drift"], "input_noise": line["input noise"], "priors": "1",
        **COPIES[line["copies"]],
    }  # fmt: skip
    found = [row for row in rows("coverage") if wanted.items() <= row.items()]
    assert line["priors"] == str(len(found))
    assert line["retarget"] == percent(found, "retarget_successes")
    assert line["own arm"] == percent(found, "own_arm_successes")


AS_IT_IS = {
    "repetition": "1", "hidden": "128", "layers": "6", "steps": "6000", "moved_copies": "16",
    "input_noise": "0.2", "weight_decay": "0.01", "members": "1", "distilled_noise": "",
}  # fmt: skip
PRIORS = {
    "as it is": {}, "12,000 steps": {"steps": "12000"}, "48 copies": {"moved_copies": "48"},
    "input noise 0.3": {"input_noise": "0.3"}, "weight decay 0.1": {"weight_decay": "0.1"},
    "3 layers": {"layers": "3"}, "256 units": {"hidden": "256"}, "mean of 3": {"members": "3"},
    "mean of 6": {"members": "6"}, "taught by 3": {"members": "3", "distilled_noise": "0.2"},
    "taught by 3, input noise 0.5": {"members": "3", "distilled_noise": "0.5"},
}  # fmt: skip


@pytest.mark.parametrize("line", table("prior seeds"), ids=lambda line: line["prior"])
def test_what_a_priors_training_leaves_to_chance(line: Row) -> None:
    wanted = AS_IT_IS | PRIORS[line["prior"]]
    found = [row for row in rows("prior_seeds") if wanted.items() <= row.items()]
    each = sorted((percent([row], "retarget_successes") for row in found), key=int)
    assert line["trainings"] == str(len(found))
    assert line["retarget"] == percent(found, "retarget_successes")
    assert (line["lowest"], line["highest"]) == (each[0], each[-1])


@pytest.mark.parametrize("line", table("recipe"), ids=lambda line: line["task, arm"])
def test_what_the_recipe_changes(line: Row) -> None:
    methods = {"own arm": "own_arm", "mapped": "lfr"}
    task, arm = line.pop("task, arm").split(", ")
    for column, said in line.items():
        asked = {"task": task, "target": arm, "method": methods.get(column, column)}
        of_both = [row for row in rows("recipe") if asked.items() <= row.items()]
        each = ([row for row in of_both if row["joint_copies"] == on] for on in "01")
        assert said == ", ".join(map(percent, each))


@pytest.mark.parametrize("line", table("execute"), ids=lambda line: " ".join(line.values()))
def test_how_many_of_a_skills_steps_to_carry_out(line: Row) -> None:
    task, arm = line["task, arm"].split(", ")
    asked = {"task": task, "target": arm, "execute": line["steps carried out"]}
    found = [row for row in rows("execute") if asked.items() <= row.items()]
    assert line["repetitions"] == str(len(found))
    for column, of in (("own arm", "own_arm"), ("retarget", "retarget"), ("mapped", "lfr")):
        measured = [row for row in found if row[f"{of}_successes"]]
        assert line[column] == percent(measured, f"{of}_successes")


HOW_COPIED = {"none": ("0", "0"), "shifted": ("0.2", "0"), "shifted, mirrored": ("0.2", "1")}


@pytest.mark.parametrize("line", table("release"), ids=lambda line: " ".join(line.values()))
def test_where_the_can_is_not_let_go(line: Row) -> None:
    shifted, mirrored = HOW_COPIED[line["copies"]]
    asked = {"task": line["task"], "target": "sawyer", "grasp_offset": line["grasp offset"],
             "late_steps": "0", "shifted_m": shifted, "mirrored": mirrored,
             "input_noise": "0.2"}  # fmt: skip
    found = [row for row in rows("release") if asked.items() <= row.items()]
    for repetition in "23":
        of_it = [row for row in found if row["repetition"] == repetition]
        assert line[f"repetition {repetition}"] == percent(of_it, "retarget_successes")


@pytest.mark.parametrize("line", table("grasp offset"), ids=lambda line: " ".join(line.values()))
def test_what_the_grasp_offset_changes_in_the_main_job(line: Row) -> None:
    task, arm = line["task, arm"].split(", ")
    asked = {"task": task, "target": arm, "grasp_offset": line["grasp offset"],
             "mirrored": {"yes": "1", "no": "0"}[line["mirrored copies"]]}  # fmt: skip
    found = {(row["method"], row["env_steps"]): row["successes"]
             for row in rows("grasp_offset") if asked.items() <= row.items()}  # fmt: skip
    for column, of in (
        ("linear", ("linear", "0")), ("retarget", ("retarget", "0")), ("mapped", ("lfr", "0")),
        ("after learning", ("lfr", "40000")),
    ):  # fmt: skip
        assert line[column] == found[of]
