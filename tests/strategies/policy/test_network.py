"""The forward pass against a case that was worked out by hand, and against PyTorch where it is there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.strategies.policy.description import PolicyDescription
from spiraltrunk.strategies.policy.network import LARGEST_INPUT, Network, forward
from spiraltrunk.strategies.policy.policy_files import load_policy

SMALL = Network(
    weights=(np.array([[1.0, -2.0], [0.5, 0.0]]), np.array([[1.0, 3.0]])), biases=(np.array([0.5, -1.0]), np.zeros(1)),
    activation="relu", output="linear", input_mean=np.array([1.0, 0.0]), input_scale=np.array([2.0, 1.0]),
    output_mean=np.array([10.0]), output_scale=np.array([2.0]),
)  # fmt: skip


def test_forward_by_hand() -> None:
    # (7 - 1) / 2 = 3 and 0.25: relu(3 - 0.5 + 0.5) = 3, relu(1.5 - 1) = 0.5, 3 + 1.5 = 4.5, 10 + 2 * 4.5 = 19.
    assert forward(SMALL, np.array([7.0, 0.25])) == pytest.approx([19.0])


def test_forward_takes_batches() -> None:
    inputs = np.array([[7.0, 0.25], [1.0, 0.0], [1.0, 1.0]])
    assert forward(SMALL, inputs).shape == (3, 1)
    assert forward(SMALL, inputs)[:, 0] == pytest.approx([forward(SMALL, row)[0] for row in inputs])


def test_far_inputs_are_bounded() -> None:
    bound = np.array([1.0 + 2.0 * LARGEST_INPUT, 0.0])
    assert forward(SMALL, np.array([1e6, 0.0])) == pytest.approx(forward(SMALL, bound))


@pytest.mark.parametrize(("activation", "output"), [("relu", "linear"), ("tanh", "tanh")])
def test_forward_equals_torch(activation: str, output: str) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    torch.manual_seed(0)
    layers = {"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh, "linear": torch.nn.Identity}
    model = torch.nn.Sequential(
        torch.nn.Linear(20, 64), layers[activation](), torch.nn.Linear(64, 64), layers[activation](),
        torch.nn.Linear(64, 9), layers[output](),
    )  # fmt: skip
    parts = [part.detach().numpy().astype(float) for part in model.parameters()]
    network = Network(
        weights=tuple(parts[::2]), biases=tuple(parts[1::2]), activation=activation, output=output,
        input_mean=np.zeros(20), input_scale=np.ones(20), output_mean=np.zeros(9), output_scale=np.ones(9),
    )  # fmt: skip
    inputs = np.random.default_rng(0).normal(size=(50, 20)).astype(np.float32)
    with torch.no_grad():
        theirs = model(torch.tensor(inputs)).numpy()
    assert np.abs(forward(network, inputs.astype(float)) - theirs).max() < 1e-5


def test_written_and_read_network_is_the_same(
    policy_file: Path, description: PolicyDescription, networks: dict[str, Network]
) -> None:
    read, found = load_policy(policy_file)
    inputs = np.random.default_rng(1).normal(size=len(description.inputs))
    assert (read.inputs, read.stages, read.latches) == (description.inputs, description.stages, description.latches)
    for key, network in networks.items():
        assert forward(found[key], inputs) == pytest.approx(forward(network, inputs), abs=1e-5)
