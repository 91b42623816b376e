"""The policy's gradient against autograd, in double precision, for all that a policy may be."""

import copy
from collections.abc import Callable

import pytest
import torch
from torch import Tensor, nn

from lfr.errors import LfrError
from lfr.mapping.generator import Generator
from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.skills.prior import SkillPrior
from lfr.transfer.extended_policy import IdentityMap, MappedPolicy, StandardNormal, initial_policy
from lfr.transfer.learning_policy import LearningPolicy
from studies.spirl.other_task import OtherTaskPrior
from studies.spirl.residual_prior import residual_prior

from .point import NAMES

Z = 4


def prior() -> SkillPrior:
    found = SkillPrior(NAMES, Z, hidden=16, layers=2)
    found.normalizer.mean.fill_(0.5)
    with torch.no_grad():  # so that some log sigmas are held at either bound
        last = found.network[-1]
        assert isinstance(last, nn.Linear)
        last.bias[Z:] = torch.linspace(LOG_SIGMA_RANGE[0] - 0.1, LOG_SIGMA_RANGE[1] + 0.1, Z)
    return found


def generator(layers: int, *names: str) -> Generator:
    g = Generator(Z, 16, layers, names)
    g.fit_scales(torch.randn(9, 2 * Z), 3.0 * torch.randn(9, 2 * Z), torch.randn(9, len(names)))
    return g


def spirl() -> nn.Module:
    inner = SkillPrior((NAMES[0], NAMES[2]), Z, 16, 2)
    return residual_prior(OtherTaskPrior(NAMES, inner.layout_names, (0, 2), Z, 16, 2), prior())


POLICIES: dict[str, Callable[[], tuple[nn.Module, Generator | IdentityMap]]] = {
    "identity": lambda: (prior(), IdentityMap()),
    "mapped": lambda: (prior(), generator(3)),
    "mapped in the state": lambda: (prior(), generator(3, *NAMES[:2])),
    "linear": lambda: (prior(), generator(1)),
    "spirl": lambda: (spirl(), IdentityMap()),
}


def in_vector(policy: MappedPolicy, gradients: list[Tensor]) -> Tensor:
    names = [name for name, p in policy.named_parameters() if p.requires_grad]
    assert all(name.startswith(("pi.network", "phi.network")) for name in names)
    return torch.cat([g.t().reshape(-1) for g in gradients])


@pytest.mark.parametrize("name", POLICIES)
@pytest.mark.parametrize("train_phi", [True, False])
@pytest.mark.parametrize("min_sigma", [0.0, 0.3])
def test_answers_and_gradient_are_autograds(name: str, train_phi: bool, min_sigma: float) -> None:
    torch.manual_seed(0)
    policy = initial_policy(*POLICIES[name](), train_phi=train_phi, min_sigma=min_sigma).double()
    reference = copy.deepcopy(policy)
    learning = LearningPolicy(policy)
    observation = torch.randn(32, 3).double()
    slopes = list(torch.randn(2, 32, Z).double())
    answers = reference(observation)
    assert name == "spirl" or len(torch.unique(answers[1])) < answers[1].numel()  # some are held
    learns = [p for p in reference.parameters() if p.requires_grad]
    wanted = torch.autograd.grad(answers, learns, slopes, allow_unused=False)
    mu, log_sigma, trace = learning.evaluate(learning.features(observation))
    torch.testing.assert_close((mu, log_sigma), answers, rtol=1e-12, atol=1e-12)
    found = learning.by_parameters(trace, *slopes)
    assert len(found) == len(learning.vector)
    expected = in_vector(reference, list(wanted))
    torch.testing.assert_close(found, expected, rtol=1e-10, atol=1e-10)
    # once more, since the gradient is written over
    again = learning.evaluate(learning.features(observation[:3]))[2]
    learning.by_parameters(again, *(slope[:3] for slope in slopes))
    torch.testing.assert_close(learning.by_parameters(trace, *slopes), expected)


def test_a_step_of_the_vector_is_one_of_the_policy() -> None:
    torch.manual_seed(0)
    policy = initial_policy(prior(), generator(3), train_phi=True)
    observation = torch.randn(5, 3)
    learning = LearningPolicy(policy)
    before = policy(observation)
    torch.testing.assert_close(learning.evaluate(learning.features(observation))[:2], before)
    learning.vector.add_(0.05 * torch.randn_like(learning.vector))
    after = policy(observation)
    assert not torch.allclose(before[0], after[0])
    torch.testing.assert_close(learning.evaluate(learning.features(observation))[:2], after)


def test_a_network_that_cannot_learn_is_named() -> None:
    with pytest.raises(LfrError, match="a policy of StandardNormal, expected a SkillPrior"):
        LearningPolicy(MappedPolicy(StandardNormal(2), IdentityMap()))
