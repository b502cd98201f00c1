"""The twin's arm: set points between two targets, as of the simulated plant."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.arm.trunk_load import trunk_load
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.sim.machine import ARM_PERIOD, SimMachine
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.drive.twin.machine_arm import MachineArm

STEP = 1e-3
SPEED = np.radians([10.0, -5.0, 5.0, 2.5, -10.0, 5.0, 15.0])
"""Speed of each joint [rad/s]."""


class Physics(TwinDevice):
    """Advances the machine after its arm, and keeps the set points."""

    def __init__(self, machine):
        self.machine, self.set_points, self.torques = machine, [], []

    def advance(self, dt):
        self.machine.advance(dt)
        self.set_points.append(self.machine.data.ctrl[self.machine._arm_motors].copy())
        self.torques.append(self.machine.read_arm()[3])


class Bench:
    def __init__(self):
        self.machine, self.clock = SimMachine(PAPER, SceneOptions(timestep=STEP)), TwinClock(step=STEP)
        self.machine.restore()
        self.arm, self.physics = MachineArm(self.machine, self.clock), Physics(self.machine)
        self.clock.attach(self.arm)
        self.clock.attach(self.physics)
        self.arm.set_load(trunk_load(PAPER))
        self.home = self.machine.reach.home

    def wait(self, seconds):
        self.clock.sleep_until(self.clock.now() + seconds)


@pytest.fixture
def bench():
    return Bench()


def test_set_points_are_on_the_straight_way_and_the_last_is_the_target(bench):
    start, target = bench.machine.data.ctrl[bench.machine._arm_motors].copy(), bench.home + SPEED * CONTROL_PERIOD
    bench.arm.send(target)
    bench.wait(2 * CONTROL_PERIOD)
    shares = np.minimum(np.floor(np.arange(2 * CONTROL_PERIOD / STEP) * STEP / ARM_PERIOD + 1e-6) + 1, 10) / 10
    expected = start + shares[:, None] * (target - bench.home)
    np.testing.assert_allclose(bench.physics.set_points, expected, atol=1e-15)


def test_holding_ends_the_way_where_it_is(bench):
    bench.arm.send(bench.home + SPEED * CONTROL_PERIOD)
    bench.wait(CONTROL_PERIOD / 2)
    bench.arm.hold()
    bench.wait(0.1)
    points = np.array(bench.physics.set_points)
    np.testing.assert_array_equal(points[10:], np.broadcast_to(points[9], points[10:].shape))
    held = points[-1] - bench.machine._servo_offset - bench.home
    np.testing.assert_allclose(held, 0.5 * SPEED * CONTROL_PERIOD, atol=1e-15)


def test_a_target_that_comes_early_begins_from_where_the_arm_is_led(bench):
    bench.arm.send(bench.home + SPEED * CONTROL_PERIOD)
    bench.wait(CONTROL_PERIOD - 2 * STEP)
    bench.arm.send(bench.home + 1.5 * SPEED * CONTROL_PERIOD)
    bench.wait(CONTROL_PERIOD)
    moves = np.abs(np.diff(bench.physics.set_points, axis=0)).max(axis=0)
    assert (moves <= 0.11 * np.abs(SPEED) * CONTROL_PERIOD).all()
    last = bench.physics.set_points[-1] - bench.machine._servo_offset
    np.testing.assert_allclose(last, bench.home + 1.5 * SPEED * CONTROL_PERIOD, atol=1e-12)


def test_the_joints_torques_are_those_of_the_simulated_plant(bench):
    """The same targets, 0.2 s long, in both: the same states in each control period."""
    plant = SimPlant(PAPER, bench.machine.options)
    plant.reset()
    worst = 0.0
    for i in range(1, 11):
        target = bench.home + i * SPEED * CONTROL_PERIOD
        bench.arm.send(target)
        bench.wait(CONTROL_PERIOD)
        plant._move_arm(target, has_arrived=False)
        for ours, theirs in zip(bench.machine.read_arm(), plant.read_arm(), strict=True):
            worst = max(worst, float(np.abs(ours - theirs).max()))
    print(f"largest difference {worst:.2g}")
    assert worst < 1e-9
