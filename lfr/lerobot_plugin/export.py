"""`lfr export`: a transferred policy as a folder for LeRobot's `--policy.path`."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import DataError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr export`."""
    parser.add_argument("policy", type=Path, help="a trained policy's folder")
    parser.add_argument("out", type=Path, help="the folder to write; nothing may be there yet")


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr export`, and say how to evaluate what it wrote.

    Raises:
        DataError: no transferred policy, a damaged one, or something where it should go.
    """
    robot, task = export_policy(arguments.policy, arguments.out)
    print(
        f"lerobot-eval {shlex.quote(f'--policy.path={arguments.out}')} "
        "--env.discover_packages_path=lfr.lerobot_plugin --env.type=lfr "
        f"--env.robot={robot} --env.task={task} --seed=0 --eval.n_episodes=100 --eval.batch_size=1"
    )
    return 0


def export_policy(folder: Path, out: Path) -> tuple[str, str]:
    """Write the policy in `folder` as LeRobot's `save_pretrained` would, whole or not at all.

    Returns:
        The embodiment and the task that it has learned.

    Raises:
        DataError: no transferred policy, a damaged one, or something where it should go.
    """
    from lfr.lerobot_plugin.configuration_lfr import LfrConfig, features_of
    from lfr.lerobot_plugin.modeling_lfr import LfrPolicy
    from lfr.lerobot_plugin.processor_lfr import make_lfr_pre_post_processors
    from lfr.model_files import read_model
    from lfr.transfer.model import KIND, load_policy

    if out.exists():
        raise DataError("there is something already; remove it or name another folder", file=out)
    load_policy(folder)  # a damaged one is refused by its own reader
    content, tensors = read_model(folder, KIND)
    about = content["about"]
    given, answered = features_of(about["robot"], about["task"])
    config = LfrConfig(
        robot=about["robot"],
        task_name=about["task"],
        networks=content["networks"],
        distribution=content.get("distribution", LfrConfig.distribution),
        min_sigma=content.get("min_sigma", LfrConfig.min_sigma),
        about={key: value for key, value in about.items() if key not in ("robot", "task")},
        input_features=given,
        output_features=answered,
        device="cpu",
        push_to_hub=False,
        license="apache-2.0",
    )
    policy = LfrPolicy(config)
    policy.load_state_dict(tensors)
    with write_whole(out) as partial:
        partial.mkdir()
        policy.save_pretrained(partial)
        for processor in make_lfr_pre_post_processors(config):
            processor.save_pretrained(partial)
    return about["robot"], about["task"]
