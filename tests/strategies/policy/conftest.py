"""Small policies with random weights, and a first observation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.control.encoding import action_names
from spiraltrunk.control.messages import Observation
from spiraltrunk.design import presets
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.policy.description import Layers, PolicyDescription, Stage
from spiraltrunk.strategies.policy.memory import MODE, list_inputs
from spiraltrunk.strategies.policy.network import Network
from spiraltrunk.strategies.policy.policy_files import write_policy

STAGES = (
    Stage(name="up", phase="transport", milestone="lifted"), Stage(name="keep", phase="transport", milestone="held"),
    Stage(name="end", phase="release", milestone="released"),
)  # fmt: skip


def draw_network(sizes: tuple[int, ...], seed: int = 0, activation: str = "relu", output: str = "linear") -> Network:
    rng = np.random.default_rng(seed)
    pairs = list(pairwise(sizes))
    weights = tuple(rng.normal(size=(after, before)).astype(np.float32).astype(float) / 8 for before, after in pairs)
    return Network(
        weights=weights, biases=tuple(rng.normal(size=after).astype(np.float32).astype(float) for _, after in pairs),
        activation=activation, output=output, input_mean=np.zeros(sizes[0]), input_scale=np.ones(sizes[0]),
        output_mean=np.zeros(sizes[-1]), output_scale=np.ones(sizes[-1]),
    )  # fmt: skip


def constant_network(n_input: int, output: np.ndarray) -> Network:
    """A network of one layer that gives the same output, whatever it takes."""
    return replace(draw_network((n_input, len(output))), weights=(np.zeros((len(output), n_input)),), biases=(output,))


@pytest.fixture(scope="session")
def build_constant() -> Callable[[int, np.ndarray], Network]:
    return constant_network


@pytest.fixture(scope="session")
def description() -> PolicyDescription:
    inputs = list_inputs(presets.PAPER, tuple(stage.name for stage in STAGES))
    outputs = action_names(MODE, presets.PAPER)
    return PolicyDescription(
        control_mode="pose-tension", inputs=inputs, outputs=outputs, n_cable=presets.PAPER.n_cable, stages=STAGES,
        networks={
            "action": Layers(sizes=(len(inputs), 8, len(outputs))), "stage": Layers(sizes=(len(inputs), len(STAGES)))
        },
        latches=("keep",), objects=("cylinder-60", "box-60"), widths=(0.02, 0.13),
        provenance={"method": "drawn", "seed": 0},
    )  # fmt: skip


@pytest.fixture(scope="session")
def networks(description: PolicyDescription) -> dict[str, Network]:
    return {key: draw_network(layers.sizes) for key, layers in description.networks.items()}


@pytest.fixture
def policy_file(description: PolicyDescription, networks: dict[str, Network], tmp_path: Path) -> Path:
    path = tmp_path / "small.safetensors"
    write_policy(path, description, networks)
    return path


@pytest.fixture(scope="session")
def observation() -> Observation:
    design = presets.PAPER
    frame = np.eye(4)
    frame[:3, :3] = [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]
    frame[:3, 3] = 0.35, 0.0, 1.2
    return Observation(
        time=0.0, task=build_task(design, SceneOptions()), T_world_base=frame, arm_position=np.zeros(7),
        arm_velocity=np.zeros(7), cable_pull=np.zeros(3), cable_tension=np.zeros(3),
        base_force=np.array([0.0, 0.0, -2.0]), base_torque=np.zeros(3),
    )  # fmt: skip
