"""Networks of fully connected layers, evaluated with NumPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

ACTIVATIONS: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "relu": lambda x: np.maximum(x, 0.0),
    "tanh": np.tanh,
    "linear": lambda x: x,
}
"""Activations by name; "linear" is the identity."""


@final
@dataclass(frozen=True, kw_only=True)
class Network:
    """A multilayer perceptron with normalised inputs and outputs."""

    weights: tuple[np.ndarray, ...]
    """Weights of each layer, shapes (n_out, n_in) [-]."""
    biases: tuple[np.ndarray, ...]
    """Biases of each layer, shapes (n_out,) [-]."""
    activation: str
    """Activation of the hidden layers, one of ACTIVATIONS."""
    output: str
    """Activation of the last layer."""
    input_mean: np.ndarray
    """Mean of each input, shape (n_in,), in the input's unit."""
    input_scale: np.ndarray
    """Scale of each input, above 0, shape (n_in,), in the input's unit."""
    output_mean: np.ndarray
    """Mean of each output, shape (n_out,), in the output's unit."""
    output_scale: np.ndarray
    """Scale of each output, above 0, shape (n_out,), in the output's unit."""

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of inputs, of units of each hidden layer, and of outputs."""
        return (self.weights[0].shape[1], *(weight.shape[0] for weight in self.weights))


LARGEST_INPUT = 10.0
"""Bound of the normalised inputs [-] (ours): a reading far out of the training data does not saturate every unit."""


def forward(network: Network, inputs: np.ndarray) -> np.ndarray:
    r"""Outputs for inputs of shape (..., n_in), shape (..., n_out).

    With :math:`h_0 = (x - m) / s` the layers are :math:`h_k = f(W_k h_{k-1} + b_k)`, and the outputs are
    :math:`m' + s' g(W_n h_{n-1} + b_n)`.
    """
    hidden = np.clip((inputs - network.input_mean) / network.input_scale, -LARGEST_INPUT, LARGEST_INPUT)
    last = len(network.weights) - 1
    for i, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
        hidden = ACTIVATIONS[network.output if i == last else network.activation](hidden @ weight.T + bias)
    return np.asarray(network.output_mean + network.output_scale * hidden)
