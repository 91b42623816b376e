"""A model's card: what it is, what it has seen, what it reached, how to load and rebuild it."""

from __future__ import annotations

from typing import Any

from huggingface_hub import EvalResult, ModelCardData

from lfr.embodiments import DEFAULT_CONTROLLER, embodiment, is_known
from lfr.hub.dataset_card import LICENSE
from lfr.hub.departures import departures
from lfr.hub.markdown import card, python, shell, table
from lfr.hub.model_facts import ModelFacts, Part
from lfr.tasks import TASKS

ABOUT = {
    "skills": "Skill VAEs and skill priors of one arm. A VAE turns a run of actions into a point "
    "of a latent space of skills and back; a prior says which skill a demonstrator would choose in "
    "a state. Where actions are motions of the joints, the Jacobian of the hand is beside them, "
    "learned from the same demonstrations. Each folder is named after the tasks that its VAE has "
    "seen, for a transfer gives an arm only what its role in it may see; transfers share them.",
    "mapping": "Generators between the skill spaces of two arms, learned on the tasks that both "
    "know: G leads from the source's latent space to the target's, F back; `linear` is the best "
    "linear map of the same pairs, for comparison.",
    "transfer": "A policy that chooses skills for an arm that has no demonstrations of the task: "
    "the other arm's skill prior behind the generator G, improved by SAC in the latent space. "
    "`initial` is where learning began, the zero-shot policy.",
}
LOAD = {
    "skill_vae": ("lfr.skills.saved_models", "load_vae", "model"),
    "skill_prior": ("lfr.skills.saved_models", "load_prior", "model"),
    "hand_jacobian": ("lfr.skills.saved_models", "load_jacobian", "model"),
    "generator": ("lfr.mapping.saved_generators", "load_generator", "model"),
    "transferred_policy": ("lfr.transfer.model", "load_policy", "actor, about"),
}


def model_card(facts: ModelFacts, *, repo_id: str | None = None, license: str | None = None) -> str:
    """The card of a folder of models, as Markdown with a YAML header.

    Args:
        facts: of the models.
        repo_id: where they are published; None is the folder in this project.
        license: None is this project's for models of its own data; of models that learned from the
            data of others nothing is claimed.
    """
    results = _results(facts)
    return card(
        _header(facts, license or (LICENSE if _simulated(facts) else None)),
        f"# {facts.title}",
        f"{ABOUT[facts.stage]} Part of lfr (Learn from Robot), after the method of Yang, Stork and "
        + (
            f"Stoyanov; simulated arms, actions {_actions(facts)}."
            if _simulated(facts)
            else "Stoyanov; of arms that are known by their datasets alone."
        ),
        "## What is in it",
        table(("folder", "kind", "arm", "tasks seen", "shape", "kB"), map(_part, facts.parts)),
        *_seen(facts),
        "## What it reached" if results else "",
        results,
        "## Load",
        _load(facts, repo_id),
        *_rebuild(facts),
        "## Known limits",
        _limits(facts),
    )


def _header(facts: ModelFacts, license: str | None) -> ModelCardData:
    scene = ("simulation", "robosuite") if _simulated(facts) else ()
    task = facts.results.get("transfer", {}).get("task")
    return ModelCardData(
        license=license,
        library_name="lfr",
        pipeline_tag="robotics",
        tags=[t for t in ("robotics", *scene, facts.stage, *_arms(facts), task) if t],
        model_name=facts.title,
        eval_results=_evaluations(facts) or None,
        ignore_metadata_errors=False,
    )


def _evaluations(facts: ModelFacts) -> list[EvalResult]:
    """The final policies' success, for the Hub's table of results."""
    learned, judged = facts.results.get("transfer"), facts.results.get("evaluate")
    if not learned or not judged:
        return []
    where = "the target's own environment"
    if is_known(learned["robot"]):
        arm = embodiment(learned["robot"]).robot
        where = f"robosuite's {TASKS[learned['task']].stock_name}, {arm.title}"
    return [
        EvalResult(
            task_type="robotics",
            task_name="robotics",
            dataset_type=f"{learned['robot']}-{learned['task']}",
            dataset_name=f"held-out starts of {where}",
            metric_type="success_rate",
            metric_name=f"success rate, seed {run['seed']}, judged by {judge}",
            metric_value=success["rate"],
        )
        for run in judged["runs"]
        for judge, success in run["success"].items()
    ]


def _part(part: Part) -> tuple[str, ...]:
    tasks = part.seen.get("tasks") or [part.seen.get("task", "")]
    shape = part.config.get("model") or {}
    sizes = [f"{key} {value}" for key, value in shape.items()
             if not isinstance(value, list | bool)]  # fmt: skip
    for name, said in (("state_names", "hand's state"), ("layout_names", "observation")):
        if shape.get(name):
            sizes.insert(0, f"{said} {len(shape[name])}")
    if shape.get("turned"):
        sizes.append("in the frame of the hand's azimuth")
    if "networks" in part.config:
        sizes = [f"{name}: {net['class']}" for name, net in part.config["networks"].items()]
    arms = " to ".join(_robots(part))
    kind = part.kind.replace("_", " ")
    return (f"`{part.place}`", kind, arms, ", ".join(tasks), ", ".join(sizes),
            f"{part.size / 1000:.0f}")  # fmt: skip


def _arms(facts: ModelFacts) -> list[str]:
    return list(dict.fromkeys(robot for part in facts.parts for robot in _robots(part)))


def _simulated(facts: ModelFacts) -> bool:
    return all(map(is_known, _arms(facts)))


def _actions(facts: ModelFacts) -> str:
    """By which controllers the arms act."""
    stock = (embodiment(robot).controller for robot in _arms(facts))
    names = {one.name: one.stock_name for one in stock}
    if set(names) == {DEFAULT_CONTROLLER}:
        return "in Cartesian space"
    return f"by {' and '.join(names.values())}"


def _robots(part: Part) -> list[str]:
    seen = part.seen
    return [seen["robot"]] if "robot" in seen else [seen[k] for k in ("source", "target")]


def _seen(facts: ModelFacts) -> list[str]:
    """The demonstrations behind the models, by the hash of their rows."""
    datasets: dict[str, str] = dict(facts.results.get("transfer", {}).get("datasets", {}))
    for part in facts.parts:
        datasets |= part.seen.get("datasets", {})
    if not datasets:
        return []
    rows = [(f"`{name}`", f"`{digest}`") for name, digest in datasets.items()]
    return ["Trained on the demonstrations of:", table(("dataset", "SHA-256 of its rows"), rows)]


def _results(facts: ModelFacts) -> str:
    if "skills" in facts.results:
        return _skill_results(facts.results["skills"])
    if "chain" in facts.results:
        return _mapping_results(facts.results["chain"])
    if chain := facts.results.get("mapping", {}).get("zero_shot"):
        report = facts.results["mapping"]
        about = {"target": report["target"], "task": next(iter(report["new"]))}
        return _mapping_results({**about, "zero_shot": chain})
    if {"transfer", "evaluate"} <= set(facts.results):
        return _transfer_results(facts.results["transfer"], facts.results["evaluate"])
    return ""


def _skill_results(noted: dict[str, Any]) -> str:
    rows = [
        (
            ", ".join(model["tasks"]),
            task,
            _rate(prior["own_arm"]) if prior.get("own_arm") else "",
            "" if prior["kl_held_out"] is None else f"{prior['kl_held_out']:.1f}",
        )
        for model in noted["models"].values()
        for task, prior in model["prior"].items()
    ]
    heads = ("tasks seen", "task", "success of the prior on its own arm",
             "KL of the prior on held-out episodes, nats")  # fmt: skip
    return table(heads, rows)


def _mapping_results(chain: dict[str, Any]) -> str:
    rows = [(link, _rate(tally)) for link, tally in chain["zero_shot"].items()]
    return (
        f"Zero-shot success of {chain['target']} at {chain['task']}, on held-out starts, link by "
        f"link; `mapped` is what these generators give.\n\n{table(('link', 'success'), rows)}"
    )


def _transfer_results(learned: dict[str, Any], judged: dict[str, Any]) -> str:
    judges = list(judged["runs"][0]["success"])
    rows = [
        (
            run["seed"],
            run["env_steps"],
            _rate(verdict["zero_shot"]),
            *(_rate(verdict["success"][judge]) for judge in judges),
        )
        for run, verdict in zip(learned["runs"], judged["runs"], strict=True)
    ]
    heads = ("seed", "environment steps", "zero-shot", *(f"after RL, by {j}" for j in judges))
    return (
        f"Success of {learned['robot']} at {learned['task']}, {learned['reward']} reward, on "
        f"held-out starts.\n\n{table(heads, rows)}"
    )


def _judged(facts: ModelFacts) -> bool:
    """Whether any success is known of it."""
    skills = facts.results.get("skills", {}).get("models", {}).values()
    own = any("own_arm" in prior for model in skills for prior in model["prior"].values())
    chain = facts.results.get("mapping", {}).get("zero_shot")
    return bool(own or chain or "evaluate" in facts.results)


def _rate(tally: dict[str, Any]) -> str:
    """Successes with the Wilson interval of 95 %."""
    low, high = 100 * tally["low"], 100 * tally["high"]
    return f"{tally['successes']} of {tally['episodes']} ({low:.0f} to {high:.0f} %)"


def _load(facts: ModelFacts, repo_id: str | None) -> str:
    others = ("initial", "jacobian")
    part = next((p for p in facts.parts if not p.place.endswith(others)), facts.parts[0])
    module, function, name = LOAD[part.kind]
    place = f'Path(snapshot_download("{repo_id}"))' if repo_id else f'Path("{facts.folder}")'
    inside = "" if part.place == "." else f' / "{part.place}"'
    fetch = ("from huggingface_hub import snapshot_download",) if repo_id else ()
    return python(
        "from pathlib import Path",
        *fetch,
        f"from {module} import {function}",
        f"{name} = {function}({place}{inside})",
    )


def _rebuild(facts: ModelFacts) -> list[str]:
    noted = facts.results.get(facts.stage)
    if not noted:
        return []
    provenance = noted["provenance"]
    changed = " (with uncommitted changes)" if provenance["modified"] else ""
    commands = shell(
        f"git checkout {provenance['revision']}",
        "make setup",
        f".venv/bin/dvc repro {'' if _simulated(facts) else 'external-'}{facts.stage}@{facts.name}",
    )
    return ["## Rebuild", f"In a checkout of lfr, the revision that made it{changed}:", commands]


def _limits(facts: ModelFacts) -> str:
    states = "It acts on states in {} observation layout, not on pictures, and needs lfr to run."
    if not _simulated(facts):
        where = "outside the environment that it was judged in" if _judged(facts) else "anywhere"
        lines = [f"No arm has moved by it {where}.", states.format("its own")]
        return "\n".join(f"- {line}" for line in lines)
    lines = [
        "Simulated: no real robot has moved.",
        states.format("lfr's"),
        "The intervals are those of the evaluation's episodes, not of the training.",
    ]
    arms = {arm.name: arm for arm in (embodiment(robot).robot for robot in _arms(facts))}
    for arm in arms.values():
        lines += departures(arm)
    return "\n".join(f"- {line}" for line in lines)
