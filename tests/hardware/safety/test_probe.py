"""Probe of each motor: exchanged, reversed and dead motors are found, and good ones pass."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.probe import PERIOD, TORQUE, ProbeState, check_answers, probe_torques, step_probe

DT = 0.002


def probe(
    respond: Callable[[tuple[float, ...]], list[float]], n_motor: int = 3, dt: float = DT
) -> tuple[int, str] | None:
    """Probe motors that report ``respond`` of what was commanded 6 ms before; the first motor with a fault."""
    state, sent, time = ProbeState(), [(0.0,) * n_motor] * 3, 0.0
    while state.motor < n_motor and time < 10.0:
        state, found = step_probe(state, respond(sent[-3]), dt)
        if found:
            assert found[1].kind is FaultKind.IMPLAUSIBLE_FEEDBACK
            return found[0], found[1].text
        sent.append(probe_torques(state, n_motor) if state.motor < n_motor else (0.0,) * n_motor)
        time += dt
        assert sum(map(abs, sent[-1])) <= TORQUE, "never more than one motor at a time"
    assert time == pytest.approx(2 * PERIOD * n_motor, abs=3 * n_motor * dt)
    pulses = [sum(one[i] > 0.0 for one in sent) * dt for i in range(n_motor)]
    assert pulses == pytest.approx([PERIOD] * n_motor, abs=2 * dt)
    return None


def test_good_motors_pass():
    assert probe(list) is None
    assert probe(lambda torques: [0.5 * one for one in torques]) is None
    assert probe(lambda torques: [one + 0.3 for one in torques]) is None, "an offset is no answer"
    assert probe(list, n_motor=1) is None
    assert probe(list, dt=0.004) is None


@pytest.mark.parametrize("dt", [0.001, 0.01, 0.013, 0.02, 0.025, 0.026, 0.027, 0.028, 0.04, 0.056])
def test_every_period_of_control_gives_samples_of_rest_and_pulse(dt):
    """Motors that report in each period what was commanded in the one before, with an offset."""
    state, told = ProbeState(), (0.0,) * 3
    for _ in range(1000):
        state, found = step_probe(state, [one + 0.3 for one in told], dt)
        assert found is None
        if state.motor == 3:
            return
        told = probe_torques(state, 3)
    raise AssertionError("the probe does not end")


@pytest.mark.parametrize(("order", "first"), [((1, 0, 2), 0), ((0, 2, 1), 1), ((1, 2, 0), 0), ((2, 1, 0), 0)])
def test_exchanged_motors_are_found(order, first):
    motor, text = probe(lambda torques: [torques[i] for i in order])
    assert motor == first
    assert f"the pulse of motor {first + 1} was answered by motor {order.index(first) + 1}" in text


def test_a_reversed_motor_is_found():
    assert probe(lambda torques: [torques[0], -torques[1], torques[2]]) == (
        1, "motor 2 pulls the wrong way; check its direction",
    )  # fmt: skip


def test_a_dead_motor_is_found():
    assert probe(lambda torques: [torques[0], torques[1], 0.0]) == (
        2, "motor 3 answered a pulse of 0.04 N m by 0.000 N m; check its mode",
    )  # fmt: skip


def test_an_answer_counts_from_its_part_of_the_pulse():
    assert check_answers(0, [0.0121, 0.0119]) is None
    assert "was answered by motor 2" in check_answers(0, [0.04, -0.0121]).text
    assert "answered a pulse" in check_answers(0, [0.0119, 0.0]).text
    assert "answered a pulse" in check_answers(0, [-0.0119, 0.0]).text
    assert "wrong way" in check_answers(0, [-0.0121, 0.0]).text


def test_what_comes_in_the_settling_time_is_not_averaged():
    """A motor that answers a third of the pulse after 16 ms, and offsets before."""
    assert probe(lambda torques: [0.32 * one for one in torques]) is None
    late: list[tuple[float, ...]] = [(0.0,) * 3] * 6

    def respond(torques):
        late.append(torques)
        return [0.32 * one for one in late[-6]]

    assert probe(respond) is None
