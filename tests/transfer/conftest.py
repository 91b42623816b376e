"""Fixtures of the transfer tests."""

import pytest
import torch

from lfr.transfer.transfer_params import TransferParams

from .point import Models, point_models, point_params


@pytest.fixture(autouse=True, scope="package")
def one_thread():
    """As in a job: two threads on matrices this small only wait for each other."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def artifacts() -> Models:
    return point_models()


@pytest.fixture
def params() -> TransferParams:
    return point_params()
