"""Privileged observation: the true state of object and world, for critics and teachers; a robot does not know it."""

from __future__ import annotations

import mujoco
import numpy as np

from spiraltrunk.sim.machine import SimMachine

_ROWS = (
    *((f"true_{axis}", -5.0, 5.0) for axis in "xyz"),
    *((f"true_axis_{axis}", -1.0, 1.0) for axis in "xyz"),
    *((f"true_turn_rate_{axis}", -100.0, 100.0) for axis in "xyz"),
    *((f"true_velocity_{axis}", -20.0, 20.0) for axis in "xyz"),
    ("true_width", 0.0, 1.0),
    ("true_length", 0.0, 1.0),
    ("true_mass", 0.0, 20.0),
    ("true_friction", 0.0, 5.0),
    ("stiffness_factor", 0.0, 2.0),
    ("grip_force", 0.0, 1000.0),
    ("string_tension", 0.0, 1000.0),
    ("touches_table", 0.0, 1.0),
)


def privileged_names() -> tuple[str, ...]:
    """Name of each number of `encode_privileged`, in order."""
    return tuple(name for name, _, _ in _ROWS)


def privileged_bounds() -> tuple[np.ndarray, np.ndarray]:
    """Least and largest values of `encode_privileged`, two of shape (n,), float32 and finite."""
    return np.array([row[1] for row in _ROWS], np.float32), np.array([row[2] for row in _ROWS], np.float32)


_LOW, _HIGH = privileged_bounds()


def encode_privileged(machine: SimMachine) -> np.ndarray:
    """The truth at the latest sample, in SI units, clipped to `privileged_bounds`, float32.

    Centre, axis, angular and linear velocity of the object in the world, its extents, mass and friction, the factor of
    the joints' stiffness, the force of the trunk on it, the tension of its strings, and whether table or ground bear
    it.
    """
    sample, scene, velocity = machine.trace[-1], machine.options, np.zeros(6)
    body = machine.model.body("object").id
    mujoco.mj_objectVelocity(machine.model, machine.data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
    values = [
        *sample.object_position.tolist(), *sample.object_axis.tolist(), *velocity.tolist(), scene.shape.width,
        scene.shape.length, scene.shape.mass, scene.shape.friction, scene.trunk.stiffness_factor, sample.grip_force,
        sample.string_tension, float(sample.touches_table),
    ]  # fmt: skip
    return np.asarray(np.clip(values, _LOW, _HIGH), dtype=np.float32)
