"""Skills, mapping and transfer between arms whose actions are different things, end to end."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks._datasets import Size, write_dataset
from lfr.artifacts import read_json
from lfr.evaluation.records import chain_records
from lfr.hub.checks import refuse_faulty_models
from lfr.hub.model_card import model_card
from lfr.hub.model_facts import read_models
from lfr.mapping.saved_generators import load_mapping_seen
from lfr.params import read_yaml
from lfr.program import run_stage
from lfr.skills.saved_models import load_prior, load_seen, load_vae
from pipeline import evaluate, mapping, skills, transfer
from tests.tiny_project import ROOT

PARAMS = """
robots: [{source}, {target}]
tasks: [lift, pick_place]
scenarios:
  j: {{common: [pick_place], new: {{{target}: lift}}, arms: [{source}, {target}]}}
transfers: [{name}]
methods: [lfr]
evaluate: {{episodes: 1, judges: [engine]}}
"""


@pytest.mark.parametrize(
    ("source", "target"),
    [("panda-joint_position", "sawyer-joint_position"), ("panda", "ur5e-joint_position")],
)
def test_a_transfer_between_arms_of_other_actions_runs(
    source: str, target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other joints, as many; and another controller with other numbers of dimensions."""
    name = f"j-{target}-lift"
    tiny = read_yaml(ROOT / "tests" / "tiny_params.yaml")
    sizes = {key: tiny[key] for key in ("seeds", "skills", "mapping", "transfer")}
    sizes["skills"] |= {"jacobian": {"hidden": 8, "steps": 30, "batch": 16}}
    sizes["skills"]["vae"] |= {"condition": "pose", "error": "hand"}
    sizes["mapping"] |= {"condition": "state", "hand": {"weight": 100.0, "batch": 8}}
    (tmp_path / "params.yaml").write_text(
        PARAMS.format(source=source, target=target, name=name)
        + "".join(f"{key}: {value}\n" for key, value in sizes.items())
    )
    for robot in (source, target):
        for task in ("lift", "pick_place"):
            path = tmp_path / "data/lerobot" / f"{robot}-{task}"
            write_dataset(path, Size(3, 30, 40), robot=robot, task_name=task)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: 1)

    for robot in (source, target):
        assert run_stage(skills.main, ["--robot", robot]) == 0
    assert run_stage(mapping.main, ["--transfer", name]) == 0
    learned = ["--transfer", name, "--method", "lfr"]
    assert run_stage(transfer.main, learned) == 0
    assert run_stage(evaluate.main, learned) == 0

    chain = chain_records([name])[name]
    assert (chain["source"], chain["target"]) == (source, target)
    links = ("own_arm", "identity", "no_generator", "recoded", "linear", "mapped", "retarget",
             "oracle")  # fmt: skip
    assert tuple(chain["zero_shot"]) == links
    found = read_json(Path("results/mapping") / f"{name}.json")
    assert all(not one["decoded_difference"] for one in found["common"].values())
    seen = [load_seen(Path("models/skills") / robot / "lift+pick_place/vae")
            for robot in (source, target)]  # fmt: skip
    assert seen[0].actions != seen[1].actions
    new = f"{source}-lift"
    assert new in load_mapping_seen(Path("models/mapping") / name / "g").datasets
    for kind, one in (("common", "pick_place"), ("new", "lift")):
        assert found[kind][one]["hand_difference"] > 0.0
    for robot in (source, target):
        of = Path("models/skills") / robot / "lift+pick_place/prior-lift"
        joints = robot.endswith("-joint_position")
        assert load_prior(of).turned == joints
        assert bool(load_vae(of.parent / "vae").state_names) == joints
        assert (of.parent / "jacobian").is_dir() == joints
        refuse_faulty_models([(part.parent, read_json(part)["kind"])
                              for part in of.parent.glob("*/config.json")])  # fmt: skip
        assert f"# skills-{robot}" in model_card(
            read_models(Path("models/skills") / robot, Path("results"))
        )

    adapted = [*learned[:3], "ap"]  # the source's actions, joint by joint
    assert run_stage(transfer.main, adapted) == 0
    assert run_stage(evaluate.main, adapted) == 0
