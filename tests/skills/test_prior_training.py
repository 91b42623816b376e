"""Priors trained as one network: their gradient by autograd, and each as if it were alone."""

import pytest
import torch
from torch import Tensor, nn
from torch.distributions import Independent, Normal, kl_divergence

from lfr.embodiments import embodiment
from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.skills.prior import SkillPrior
from lfr.skills.prior_ensemble import PriorEnsemble
from lfr.skills.skill_params import PriorParams
from lfr.skills.skill_training import PriorMaterial, train_priors
from lfr.skills.symmetry import AS_RECORDED, SymmetryParams
from lfr.skills.vae import SkillVAE
from lfr.tasks import task

OSC = embodiment("panda").action.names
TASKS = ("lift", "nut_assembly", "stack")  # of 22, 34 and 33 numbers or so: none like another


def names(name: str) -> tuple[str, ...]:
    return task(name).observation.names


def observations(name: str, count: int, seed: int = 0) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    return 0.2 * torch.randn(count, len(names(name)), generator=generator)


def prior(name: str, seed: int) -> SkillPrior:
    torch.manual_seed(seed)
    made = SkillPrior(names(name), latent_dim=3, hidden=8, layers=2)
    made.normalizer.fit(observations(name, 50), names(name))
    return made


def task_loss(one: SkillPrior, seen: Tensor, mu: Tensor, log_sigma: Tensor) -> Tensor:
    """L_task of Eq. 3, by torch's own distributions."""
    mu_p, log_sigma_p = one(seen)
    posterior, predicted = Normal(mu, log_sigma.exp()), Normal(mu_p, log_sigma_p.exp())
    return kl_divergence(Independent(posterior, 1), Independent(predicted, 1)).mean()


@pytest.mark.parametrize("spread", [1.0, 30.0], ids=["within the bounds", "at the bounds"])
def test_the_gradient_is_that_of_each_prior_by_itself(spread: float) -> None:
    priors = [prior(name, seed) for seed, name in enumerate(TASKS)]
    for one in priors:
        last = one.network[-1]
        assert isinstance(last, nn.Linear)
        with torch.no_grad():
            last.weight[3:] *= spread
    generator = torch.Generator().manual_seed(1)
    mu, log_sigma = torch.randn(2, len(TASKS), 16, 3, generator=generator)
    seen = [5.0 * observations(name, 16, seed=9) for name in TASKS]
    expected = []
    for k, one in enumerate(priors):
        loss = task_loss(one, seen[k], mu[k], log_sigma[k])
        expected.append(torch.autograd.grad(loss, list(one.parameters())))
    if spread > 1.0:
        bounds = torch.tensor(LOG_SIGMA_RANGE)
        assert torch.isin(priors[0](seen[0])[1], bounds).any()

    ensemble = PriorEnsemble(priors)
    inputs = ensemble.networks.together(
        [one.normalizer(rows) for one, rows in zip(priors, seen, strict=True)]
    )
    ensemble.networks.vector.copy_(ensemble.gradient(inputs, mu, log_sigma))
    ensemble.networks.write_back()  # the gradient, read as parameters
    for one, gradients in zip(priors, expected, strict=True):
        for found, wanted in zip(one.parameters(), gradients, strict=True):
            torch.testing.assert_close(found.detach(), wanted, rtol=1e-3, atol=1e-4)


def materials(count: int = 64) -> list[PriorMaterial]:
    made = []
    for seed, name in enumerate(TASKS):
        seen = observations(name, count, seed)
        actions = torch.tanh(5 * seen[:, None, :7]).expand(-1, 4, -1).contiguous()
        made.append(PriorMaterial(seen, actions, names(name), OSC, seed))
    return made


@pytest.fixture(scope="module")
def vae() -> SkillVAE:
    torch.manual_seed(0)
    return SkillVAE(4, 7, 3, 8)


@pytest.mark.parametrize("symmetry", [AS_RECORDED, SymmetryParams(copies=2)])
def test_a_prior_is_what_it_would_be_by_itself(vae: SkillVAE, symmetry: SymmetryParams) -> None:
    params = PriorParams(hidden=16, layers=2, steps=40, batch=16, symmetry=symmetry)
    together = train_priors(vae, materials(), params)
    for one, material in zip(together, materials(), strict=True):
        (alone,) = train_priors(vae, [material], params)
        for name, found in one.state_dict().items():
            torch.testing.assert_close(found, alone.state_dict()[name], rtol=1e-3, atol=1e-4)


def test_priors_learn_the_skill_of_a_state_and_a_seed_fixes_them(vae: SkillVAE) -> None:
    params = PriorParams(hidden=32, layers=2, steps=150, batch=32)
    trained, again = (train_priors(vae, materials(), params) for _ in range(2))
    start = train_priors(vae, materials(), PriorParams(hidden=32, layers=2, steps=0))
    for k, material in enumerate(materials()):
        with torch.no_grad():
            skills = vae.encode(material.actions)
            losses = [
                float(task_loss(one[k], material.observations, *skills)) for one in (trained, start)
            ]
        assert losses[0] < 0.3 * losses[1]
        states = trained[k].state_dict(), again[k].state_dict()
        assert all(torch.equal(states[0][name], states[1][name]) for name in states[0])


@pytest.mark.parametrize("turned", [False, True])
def test_a_prior_sees_what_its_material_says(turned: bool) -> None:
    vae, windows = SkillVAE(4, len(OSC), 3, 8), torch.rand(20, 4, len(OSC))
    material = PriorMaterial(observations("lift", 20), windows, names("lift"), OSC, 0, turned)
    (made,) = train_priors(vae, [material], PriorParams(8, 2, steps=1, batch=4))
    assert made.turned == made.normalizer.turned == turned
