"""What every arm must do: tests over a fixture ``arm_bench`` of class `ArmBench`; import them all where it is defined.

An arm on the bench stands at a pose from which each joint can move by 0.1 rad either way.
"""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmLoad
from spiraltrunk.hardware.arm.checks import position_range

LOAD = ArmLoad(mass=1.5, center=np.array([0.0, 0.01, 0.1]), inertia=np.diag([0.01, 0.01, 0.005]))


def test_reads_fresh_state(arm_bench):
    first = arm_bench.arm.read()
    arm_bench.advance(0.02)
    second = arm_bench.arm.read()
    assert second.time - first.time == pytest.approx(0.02, abs=1e-6)
    assert second.error is None
    n = arm_bench.settings.n_joint
    for part in (second.position, second.velocity, second.acceleration, second.torque):
        assert part.shape == (n,)
        assert np.isfinite(part).all()


def test_follows_small_steps(arm_bench):
    start = arm_bench.arm.read().position
    arm_bench.step(np.full(start.size, 0.05), 20)
    arm_bench.advance(0.04)
    state = arm_bench.arm.read()
    assert state.error is None
    np.testing.assert_allclose(state.position, start + 0.05, atol=0.01)
    assert arm_bench.sent() == 20


def hostile_targets(bench):
    """Targets that no arm may get, by name."""
    here = bench.arm.read().position
    low, high = position_range(bench.settings)
    n = here.size

    def put(i, value):
        target = here.copy()
        target[i] = value
        return target

    for i in range(n):
        for value in (np.nan, np.inf, -np.inf, 1e300, -1e300):
            yield f"joint {i} at {value}", put(i, value)
        yield f"joint {i} just above", put(i, np.nextafter(high[i], np.inf))
        yield f"joint {i} just below", put(i, np.nextafter(low[i], -np.inf))
        for sign in (1.0, -1.0):
            yield f"joint {i} jumps", put(i, here[i] + sign * 0.5)
            step = 1.5 * bench.settings.period * bench.settings.limits.velocity[i]
            yield f"joint {i} too fast", put(i, here[i] + sign * step)
    yield "short", here[:-1]
    yield "long", np.append(here, 0.0)
    yield "square", np.tile(here, (n, 1))
    yield "empty", np.array([])
    yield "a number", np.array(0.1)
    yield "texts", np.array(["a"] * n)
    yield "nothing", None
    yield "ragged", [[0.0], 0.0, 0.0]
    yield "complex", here + 0j


def is_refused(arm, target):
    """Whether sending the target raises the error that drivers raise."""
    try:
        arm.send(target)
    except DriveError:
        return True
    return False


def test_refuses_every_hostile_target_before_anything_is_sent(arm_bench):
    before = arm_bench.sent()
    cases = list(hostile_targets(arm_bench))
    assert len(cases) > 70
    for name, target in cases:
        arm_bench.advance(arm_bench.settings.period)
        assert is_refused(arm_bench.arm, target), name
    assert arm_bench.sent() == before
    assert arm_bench.arm.read().error is None
    arm_bench.arm.send(arm_bench.arm.read().position)
    assert arm_bench.sent() == before + 1


def test_refuses_random_targets_beyond_limits(arm_bench):
    low, high = position_range(arm_bench.settings)
    here, rng = arm_bench.arm.read().position, np.random.default_rng(7)
    for _ in range(300):
        target, i = here.copy(), rng.integers(here.size)
        target[i] = rng.choice([high[i] + rng.exponential(), low[i] - rng.exponential()])
        with pytest.raises(DriveError, match=f"joint {i + 1} "):
            arm_bench.arm.send(target)
    assert arm_bench.sent() == 0


def test_refuses_targets_that_come_too_fast(arm_bench):
    start, period = arm_bench.arm.read().position, arm_bench.settings.period
    step = np.zeros(start.size)
    step[0] = 0.9 * period * arm_bench.settings.limits.velocity[0]
    arm_bench.arm.send(start + step)
    arm_bench.advance(0.1 * period)
    with pytest.raises(DriveError, match="periods"):
        arm_bench.arm.send(start + 2 * step)
    assert arm_bench.sent() == 1


def speed_up(arm_bench):
    """Targets of joint 1, from here on, that speed up as fast as is allowed to 0.99 of its speed limit."""
    target, period, speed = arm_bench.arm.read().position.copy(), arm_bench.settings.period, 0.0
    while True:
        yield target.copy()
        most, limits = 0.99 * period * arm_bench.settings.limits.acceleration[0], arm_bench.settings.limits
        speed = min(0.99 * limits.velocity[0], speed + most)
        target[0] += period * speed


def test_full_speed_at_a_steady_rate_passes(arm_bench):
    for target in islice(speed_up(arm_bench), 25):
        arm_bench.arm.send(target)
        arm_bench.advance(arm_bench.settings.period)
    assert arm_bench.sent() == 25


def test_targets_that_speed_up_or_brake_too_fast_are_refused(arm_bench):
    arm, period = arm_bench.arm, arm_bench.settings.period
    targets = list(islice(speed_up(arm_bench), 8))
    for target in targets:
        arm.send(target)
        arm_bench.advance(period)
    step = targets[-1] - targets[-2]
    for sudden in (targets[-1], targets[-1] - step, targets[-1] + 1.5 * step):
        with pytest.raises(DriveError, match=r"joint 1 asks for .*: targets whose speed changes more slowly"):
            arm.send(sudden)
    assert arm_bench.sent() == 8
    arm.send(targets[-1] + step)
    assert arm_bench.sent() == 9
    arm.hold()
    arm_bench.advance(period)
    before = arm_bench.sent()
    arm.send(arm.read().position)
    assert arm_bench.sent() == before + 1


def test_sent_targets_are_not_the_callers_array(arm_bench):
    target = arm_bench.arm.read().position.copy()
    arm_bench.arm.send(target)
    target[:] = np.nan
    arm_bench.advance(0.02)
    assert np.isfinite(arm_bench.arm.read().position).all()


def test_hold_always_works(arm_bench):
    arm = arm_bench.arm
    arm.hold()
    arm_bench.step(np.full(arm.read().position.size, 0.05), 20)
    arm.hold()
    arm.hold()
    arm_bench.advance(0.5)
    stopped = arm.read().position
    arm_bench.advance(0.5)
    np.testing.assert_allclose(arm.read().position, stopped, atol=2e-3)
    arm_bench.fail()
    arm.hold()
    arm.close()
    arm.hold()


def test_goes_on_after_hold(arm_bench):
    arm_bench.step(np.full(arm_bench.settings.n_joint, 0.02), 10)
    arm_bench.arm.hold()
    arm_bench.advance(0.5)
    arm_bench.step(np.full(arm_bench.settings.n_joint, -0.02), 10)
    assert arm_bench.arm.read().error is None


def test_close_is_idempotent_and_final(arm_bench):
    arm = arm_bench.arm
    position = arm.read().position
    arm.close()
    arm.close()
    arm.hold()
    for refused in (arm.read, lambda: arm.send(position), lambda: arm.set_load(LOAD)):
        with pytest.raises(DriveError, match="closed"):
            refused()


def test_load_is_set_while_it_stands(arm_bench):
    arm_bench.arm.set_load(LOAD)
    assert arm_bench.loaded() == LOAD.mass
    arm_bench.step(np.full(arm_bench.settings.n_joint, 0.02), 10)
    arm_bench.arm.hold()
    arm_bench.advance(0.5)
    arm_bench.arm.set_load(ArmLoad(mass=1.0, center=LOAD.center, inertia=LOAD.inertia))
    assert arm_bench.loaded() == 1.0


def test_load_is_refused_while_it_moves(arm_bench):
    arm_bench.step(np.full(arm_bench.settings.n_joint, 0.05), 20)
    with pytest.raises(DriveError, match="hold it"):
        arm_bench.arm.set_load(LOAD)
    assert arm_bench.loaded() == 0.0


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mass": np.nan}, "mass"),
        ({"mass": -1.0}, "mass"),
        ({"mass": 3.01}, "allowed: 3 kg"),
        ({"center": np.array([0.0, np.inf, 0.0])}, "centre"),
        ({"center": np.array([0.0, 3.0, 0.0])}, "centre"),
        ({"inertia": np.zeros((3, 3))}, "principal"),
        ({"inertia": np.diag([1.0, 0.1, 0.1])}, "principal"),
        ({"inertia": np.arange(9.0).reshape(3, 3)}, "symmetric"),
        ({"inertia": np.full((3, 3), np.nan)}, "inertia"),
    ],
)
def test_refuses_impossible_loads(arm_bench, change, said):
    load = ArmLoad(**{"mass": LOAD.mass, "center": LOAD.center, "inertia": LOAD.inertia, **change})
    with pytest.raises(DriveError, match=said):
        arm_bench.arm.set_load(load)
    assert arm_bench.loaded() == 0.0


def test_a_lost_connection_is_told_and_stays(arm_bench):
    arm_bench.step(np.full(arm_bench.settings.n_joint, 0.02), 10)
    position, before = arm_bench.arm.read().position, arm_bench.sent()
    arm_bench.fail()
    state = arm_bench.arm.read()
    assert state.error
    assert np.isfinite(state.position).all()
    arm_bench.arm.send(position)
    assert arm_bench.sent() == before
    assert arm_bench.arm.read().error == state.error
    with pytest.raises(DriveError, match="takes no load"):
        arm_bench.arm.set_load(LOAD)
