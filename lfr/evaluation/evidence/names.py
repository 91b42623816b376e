"""Methods and zero-shot links: their order in tables and figures, and what they are called."""

from __future__ import annotations

from collections.abc import Iterable

METHODS = {
    "lfr": "LfR",
    "bc_rnn": "BC+RNN",
    "ap": "AP",
    "sac": "SAC",
    "no_generator": "no generator",
    "only_lift": "only Lift",
    "only_nut_assembly": "only Nut Assembly",
    "only_pick_place": "only Pick-Place",
    "shared_vae": "shared VAE",
    "spirl": "SPiRL (common prior)",
    "spirl_no_prior": "SPiRL (no prior)",
    "wrong_task": "wrong task's prior",
}
"""Methods that learn, ours first, then the paper's baselines, ablations, and the questions."""

LINKS = {
    "own_arm": "source prior and source decoder on the source arm: what the source itself can do",
    "oracle": "the target's own prior, of its own demonstrations of the new task",
    "oracle_decoder": "mapped, with a target decoder that has seen the new task",
    "identity": "source prior and source decoder on the target: the arms' difference alone",
    "recoded": "identity's actions through the target's VAE: what that VAE can say",
    "mapped": "source prior, G, target decoder: where LfR starts",
    "shared_vae": "one VAE for both arms, so nothing to map",
    "linear": "G as a closed-form linear map",
    "no_cycle": "G without the cycle loss (lambda 0)",
    "only_lift": "G of the common task Lift alone",
    "only_nut_assembly": "G of the common task Nut Assembly alone",
    "only_pick_place": "G of the common task Pick-Place alone",
    "between_seeds": "between two VAE seeds of one arm: the latents' coordinates alone",
    "wrong_task": "the prior of another task, mapped",
    "no_generator": "source latents straight into the target's decoder",
    "shuffled": "G of pairs that do not belong together",
    "untrained": "G as initialised",
    "constant": "one and the same distribution in every state",
}
"""Zero-shot links: each arm by itself, the chain, other ways to map, and what ought to fail."""

REWARDS = ("sparse", "dense")


def method_label(method: str) -> str:
    """What a method is called; one that is not known here, by its key."""
    return METHODS.get(method, method.replace("_", " "))


def link_label(link: str) -> str:
    """What a link is called in a sentence."""
    return METHODS.get(link, link.replace("_", " "))


def in_order(found: Iterable[str], known: Iterable[str]) -> list[str]:
    """What was found, in the known order, and then what is not known, by the alphabet."""
    order = {name: place for place, name in enumerate(known)}
    return sorted(set(found), key=lambda name: (order.get(name, len(order)), name))
