"""Parameters: what fits is read, what does not is named together with what would."""

import dataclasses
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfr.artifacts import as_json
from lfr.errors import ParameterError
from lfr.params import read_section
from lfr.records import from_mapping


@dataclass(frozen=True)
class Network:
    hidden: tuple[int, ...] = (128, 128)
    layer_norm: bool = False


@dataclass(frozen=True)
class Learner:
    rate: float
    reward: Literal["sparse", "dense"] = "sparse"
    steps: int = 10
    target: float | None = None
    either: int | str = 1
    window: tuple[int, float] = (1, 1.0)
    weights: dict[str, float] = field(default_factory=dict)
    network: Network = Network()

    def __post_init__(self) -> None:
        if self.rate <= 0:
            raise ValueError(f"rate is {self.rate}, expected above 0")


def test_reads_nested_values_and_keeps_defaults() -> None:
    given_values = {
        "rate": 1,
        "target": 2,
        "either": "x",
        "window": [3, 4],
        "weights": {"kl": 1},
        "network": {"hidden": [8]},
    }
    read = from_mapping(Learner, given_values, "p.yaml: learner")
    assert read == Learner(
        1.0, target=2.0, either="x", window=(3, 4.0), weights={"kl": 1.0}, network=Network((8,))
    )
    assert type(read.rate) is float
    assert type(read.weights["kl"]) is float


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"rat": 1.0}, "p: unknown parameter 'rat'; valid: rate, reward, steps, target, either"),
        ({}, "p: parameter 'rate' is missing"),
        ({"rate": "1.0"}, "p: rate: found '1.0', expected float"),
        ({"rate": True}, "p: rate: found True, expected float"),
        ({"rate": 0.0}, "p: rate is 0.0, expected above 0"),
        ({"rate": 1.0, "steps": True}, "steps: found True, expected int"),
        ({"rate": 1.0, "steps": 1.0}, "steps: found 1.0, expected int"),
        ({"rate": 1.0, "steps": None}, "steps: found None, expected int"),
        ({"rate": 1.0, "target": "a"}, "target: found 'a', expected float"),
        ({"rate": 1.0, "either": 1.5}, "either: found 1.5, expected int or str"),
        ({"rate": 1.0, "reward": "shaped"}, "reward: found 'shaped'; valid: sparse, dense"),
        ({"rate": 1.0, "window": [1]}, "window: found 1 values, expected 2"),
        ({"rate": 1.0, "window": 1}, r"window: found 1, expected tuple\[int, float\]"),
        ({"rate": 1.0, "weights": {"kl": "x"}}, "weights.kl: found 'x', expected float"),
        ({"rate": 1.0, "network": {"hiden": []}}, "network: unknown parameter 'hiden'; valid: hi"),
        ({"rate": 1.0, "network": {"hidden": [8, "x"]}}, r"network.hidden\[1\]: found 'x', expect"),
        ({"rate": 1.0, "network": 3}, "network: found 3, expected a mapping"),
    ],
)
def test_names_what_does_not_fit(values: dict[str, object], message: str) -> None:
    with pytest.raises(ParameterError, match=message) as caught:
        from_mapping(Learner, values, "p")
    assert "\n" not in str(caught.value)


@given(
    st.builds(
        Learner,
        rate=st.floats(min_value=1e-6, allow_infinity=False),
        reward=st.sampled_from(["sparse", "dense"]),
        steps=st.integers(),
        target=st.none() | st.floats(allow_nan=False),
        either=st.integers() | st.text(),
        window=st.tuples(st.integers(), st.floats(allow_nan=False)),
        weights=st.dictionaries(st.text(), st.floats(allow_nan=False)),
        network=st.builds(Network, hidden=st.lists(st.integers()).map(tuple)),
    )
)
def test_what_is_written_out_is_read_back(learner: Learner) -> None:
    assert from_mapping(Learner, as_json(learner), "p") == learner


def test_a_section_and_a_section_of_it(tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text("transfer:\n  learner: {rate: 5e-4, network: {layer_norm: true}}\n")
    learner = read_section(Learner, "transfer.learner", path)
    assert learner.rate == 0.0005  # YAML 1.1 would read the text "5e-4"
    assert learner.network.layer_norm is True
    assert dataclasses.replace(learner, rate=1.0, network=Network()) == Learner(1.0)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("skills: {}\nrecord: {}\n", "params.yaml: no section 'learner'; found: record, skills"),
        ("learner:\n", "params.yaml: learner: found None, expected a mapping"),
        ("learner: {rate: 1, rate: 2}\n", "params.yaml is no YAML: .*duplicate key"),
        ("learner: [\n", "params.yaml is no YAML"),
        ("3\n", "params.yaml: expected a mapping of sections"),
    ],
)
def test_a_file_that_does_not_hold_it(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(content)
    with pytest.raises(ParameterError, match=message) as caught:
        read_section(Learner, "learner", path)
    assert "\n" not in str(caught.value)


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="is missing; run in the project's folder"):
        read_section(Learner, "learner", tmp_path / "params.yaml")
