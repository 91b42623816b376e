"""Training on a CUDA device against the same on the processor; what is asked of one that is not."""

import dataclasses
from typing import Any

import pytest
import torch
from torch import Tensor, nn

from lfr.embodiments import embodiment
from lfr.errors import ParameterError
from lfr.mapping.hand_loss import SourceTask, hand_loss
from lfr.mapping.mapping_params import HandLossParams, MappingParams
from lfr.mapping.mapping_training import Pairs, train_mapping
from lfr.networks.device import CPU, DeviceName, device_named
from lfr.skills.condition import Condition
from lfr.skills.skill_params import PriorParams, VAEParams
from lfr.skills.skill_training import PriorMaterial, train_priors, train_vae
from lfr.skills.symmetry import SymmetryParams
from lfr.skills.vae import SkillVAE
from lfr.spaces import ROBOT_STATE
from lfr.tasks import task
from lfr.transfer.loop import TransferLoop

from ..mapping.made_up import arm, prior, states
from ..transfer.point import PointSimulation, lfr_initialization, point_models, point_params

OSC = embodiment("panda").action.names
NEAR: dict[str, float] = {"rtol": 1e-2, "atol": 1e-3}
NAMES: list[DeviceName] = ["cpu", "cuda"]

needs_cuda = pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")


def windows(count: int) -> Tensor:
    return torch.rand(count, 10, len(OSC), generator=torch.Generator().manual_seed(1)) * 2.0 - 1.0


def alike(one: nn.Module, other: nn.Module) -> None:
    """All weights but one in 500: where a gradient is no more than rounding, Adam enlarges it."""
    apart = []
    for (name, a), b in zip(one.state_dict().items(), other.state_dict().values(), strict=True):
        assert a.device == b.device == CPU, name
        apart.append(~torch.isclose(a, b, **NEAR).flatten())
    assert torch.cat(apart).double().mean() < 2e-3


def test_auto_is_the_processor_where_there_is_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert device_named("auto") == device_named("cpu") == CPU
    with pytest.raises(ParameterError, match="torch finds no CUDA device"):
        device_named("cuda")


def test_auto_is_cuda_where_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert device_named("auto") == device_named("cuda") == torch.device("cuda")
    assert device_named("cpu") == CPU


@needs_cuda
def test_a_skill_vae_and_its_priors_are_those_of_the_processor() -> None:
    params = VAEParams(latent_dim=4, hidden=32, steps=12, batch=32)
    first, second = (
        train_vae(windows(200), OSC, params, 3, device_named(name)) for name in NAMES
    )  # fmt: skip
    alike(first, second)

    def material(name: str, seed: int) -> PriorMaterial:
        layout = task(name).observation.names
        seen = 0.2 * torch.randn(200, len(layout), generator=torch.Generator().manual_seed(seed))
        return PriorMaterial(seen, windows(200), layout, OSC, seed)

    some = PriorParams(32, 2, steps=12, batch=32, symmetry=SymmetryParams(copies=2))
    for one, other in zip(
        *(train_priors(first, [material("lift", 1), material("stack", 2)], some, device_named(name))
          for name in NAMES),
        strict=True,
    ):  # fmt: skip
        alike(one, other)


@needs_cuda
def test_a_mapping_is_that_of_the_processor() -> None:
    generator = torch.Generator().manual_seed(0)
    pairs = Pairs(*torch.randn(2, 500, 8, generator=generator))
    found = [
        train_mapping(pairs, MappingParams(steps=12, hidden=32, batch=64, device=name), 5)
        for name in NAMES
    ]
    for one, other in zip(*found, strict=True):
        alike(one, other)


@needs_cuda
def test_a_mapping_held_to_the_hand_is_that_of_the_processor() -> None:
    arms = [arm(name, seed) for seed, name in enumerate(("panda-joint_position", "sawyer"))]
    tasks = [SourceTask(prior(), states(200))]
    found = []
    for name in NAMES:
        hand = HandLossParams(weight=30.0, batch=16)
        params = MappingParams(steps=12, hidden=32, batch=64, device=name, hand=hand)
        compared = hand_loss(tasks, *arms, params, seed=0, count=200)
        pairs = Pairs(compared.k_x, compared.k_x.flip(0), compared.states)
        condition = Condition(ROBOT_STATE.names, turned=True)
        found.append(train_mapping(pairs, params, 5, condition, compared))
        assert next(arms[1].vae.parameters()).device.type == "cpu"
    for one, other in zip(*found, strict=True):
        alike(one, other)


@needs_cuda
def test_a_run_is_that_of_the_processor_and_goes_on_on_the_other_one(tmp_path: Any) -> None:
    def loop(name: DeviceName, **changes: Any) -> TransferLoop:
        params = dataclasses.replace(point_params(), device=name, **changes)
        start = lfr_initialization(point_models(), params)
        return TransferLoop(start, [PointSimulation() for _ in range(2)], params, 0)

    loops = [loop(name) for name in NAMES]
    for one in loops:
        one.run()
    on_cpu, on_cuda = loops
    assert on_cuda.actor.device.type == "cuda"
    assert [p.env_steps for p in on_cpu.curve] == [p.env_steps for p in on_cuda.curve]
    assert on_cpu.progress == on_cuda.progress
    for name, value in on_cpu.learner.state().items():
        torch.testing.assert_close(value, on_cuda.learner.state()[name].cpu(), **NEAR)
    torch.testing.assert_close(on_cpu.replay.rows, on_cuda.replay.rows, **NEAR)

    content, tensors = on_cuda.state()
    assert content["curve"]
    on_cpu.learner.load_state(
        {k.removeprefix("learner."): v for k, v in tensors.items() if k.startswith("learner.")}
    )
    for name, value in on_cpu.learner.state().items():
        assert torch.equal(value, on_cuda.learner.state()[name].cpu()), name
    assert isinstance(on_cuda.actor.decoder, SkillVAE)
