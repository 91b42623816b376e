"""A Hub on this machine, and a dataset and models to publish there."""

import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.curation import made_up

from .server import Hub, serving

TOKEN = "hf_madeUpSecretOfNobody"
LENGTHS = (12, 9, 15)
IMAGE_SIZE = 64


@pytest.fixture(scope="session")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hub") / "logs"
    made_up.write_all(folder, LENGTHS, IMAGE_SIZE)
    return folder


@pytest.fixture(scope="session")
def dataset(logs: Path) -> Path:
    """Do not write to it: copy it first."""
    from lfr.data.dataset import pack_dataset

    out = logs.parent / "panda-lift"
    pack_dataset(sorted(logs.iterdir()), out, video=True)
    return out


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Skill models of an arm: a VAE and a prior."""
    import torch

    from lfr.skills.prior import SkillPrior
    from lfr.skills.saved_models import Seen, save_prior, save_vae
    from lfr.skills.vae import SkillVAE

    torch.manual_seed(0)
    folder = tmp_path_factory.mktemp("hub") / "sawyer"
    seen = Seen("sawyer", ("lift",), {"sawyer-lift": "0" * 64}, seed=0)
    save_vae(folder / "lift+stack" / "vae", SkillVAE(4, 7, 3, 8, 2), seen)
    prior = SkillPrior(("number.a", "number.b"), 3, 8, 2)
    save_prior(folder / "lift+stack" / "prior-lift", prior, seen)
    return folder


@pytest.fixture
def hub(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Hub]:
    """The Hub, as HF_ENDPOINT, HF_TOKEN, HF_HOME and HF_HUB_DISABLE_XET=1 would set it.

    huggingface_hub reads its environment when it is imported, so its constants are set instead.
    It waits no time before it tries again.
    """
    import huggingface_hub.constants as constants
    from huggingface_hub.utils import _http

    with serving(Hub(TOKEN)) as hub:
        monkeypatch.setenv("HF_TOKEN", TOKEN)
        monkeypatch.setattr(constants, "HF_HUB_DISABLE_XET", True)
        monkeypatch.setattr(constants, "HF_HUB_OFFLINE", False)
        monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr(constants, "ENDPOINT", hub.url)
        template = f"{hub.url}/{{repo_id}}/resolve/{{revision}}/{{filename}}"
        monkeypatch.setattr(constants, "HUGGINGFACE_CO_URL_TEMPLATE", template)
        impatient = SimpleNamespace(**{**vars(time), "sleep": lambda seconds: None})
        monkeypatch.setattr(_http, "time", impatient)
        yield hub
