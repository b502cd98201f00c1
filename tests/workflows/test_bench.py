"""The performance claims compare like with like: each rival gives our answer, and no timing can fail a test."""

from __future__ import annotations

import importlib.util
import json
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.model import reference
from spiraltrunk.sim.relaxation.relax import RelaxationRig
from spiraltrunk.workflows.bench import CLAIMS, PEERS, Claim, bending, elastica, equilibrium, reach, rest
from spiraltrunk.workflows.bench.claim import one_core, time_burst, time_in_turns

PAPER = presets.PAPER


def bends(shape):
    return np.arctan2(shape.joint_rotation[..., 1, 0], shape.joint_rotation[..., 0, 0])


def farthest(a, b):
    return float(np.linalg.norm(a - b, axis=-1).max())


def test_a_claim_holds_from_its_bar_on():
    claim = Claim(ours=2.0, other=20.0, bar=10.0)
    assert claim.ratio == 10.0
    assert claim.holds
    assert not replace(claim, ours=2.01).holds


def test_the_fastest_turn_counts():
    waits = {"short": iter([0.0, 0.02, 0.002] + [0.02] * 9), "long": iter([0.0, 0.03, 0.03] + [0.006] * 9)}

    def wait(name):
        return lambda: time.sleep(next(waits[name], 0.02))

    short, long = time_in_turns(wait("short"), wait("long"), turns=4, span=0.0)
    assert 0.002 <= short < 0.02
    assert 0.006 <= long < 0.03
    assert time_burst(lambda: time.sleep(0.001), 3) >= 0.001


def test_one_core_and_then_all_again():
    cores = os.sched_getaffinity(0)
    with one_core():
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == cores


@pytest.mark.parametrize("tilt", rest.TILTS)
def test_scipy_solves_the_same_rest(tilt):
    rival, shape = rest.NumpyRest(tilt), reference.rest(PAPER, tilt)
    np.testing.assert_allclose(rival.solve(), -bends(shape), atol=1e-9)
    step = 1e-6 * np.eye(PAPER.n_joint)
    sag = rival.solve()
    slopes = [(rival.residual(sag + s) - rival.residual(sag - s)) / 2e-6 for s in step]
    np.testing.assert_allclose(rival.jacobian(sag), np.transpose(slopes), atol=1e-9)


@pytest.mark.parametrize("pull", [0.0, 0.02, bending.PULL, bending.MOST])
def test_the_law_with_a_matrix_chain_is_the_same_law(pull):
    shape = reference.bend_dorsal(PAPER, pull, bending.TILT)
    ends, angle, change = bending.NumpyBending(bending.TILT).bend_one(pull)
    np.testing.assert_allclose(ends, shape.points, atol=1e-14)
    np.testing.assert_allclose(angle, shape.joint_angle, atol=1e-12)
    np.testing.assert_allclose(change, shape.cable_change, atol=1e-14)


@pytest.mark.parametrize("tilt", [bending.TILT, 1.5, -1.0])
def test_the_law_over_arrays_is_the_same_law(tilt):
    pulls = np.linspace(0.0, bending.MOST, 400)
    ends, bend = bending.NumpyBending(tilt).bend(pulls, np.zeros((3, PAPER.n_section, 400)))
    shape = reference.bend_dorsal(PAPER, pulls, tilt)
    np.testing.assert_allclose(bend, bends(shape), atol=1e-12)
    np.testing.assert_allclose(ends, shape.points, atol=1e-13)


@pytest.mark.parametrize("tilt", rest.TILTS[:2])
def test_tuned_mujoco_comes_to_rest(tilt):
    """Within 0.5 mm of where it rests when nobody hurries."""
    hurried = RelaxationRig(PAPER, theta_0=tilt, options=rest.TUNED).relax()
    patient = RelaxationRig(PAPER, theta_0=tilt, options=replace(rest.TUNED, still=1e-6)).relax()
    assert hurried.shape.status == patient.shape.status == 0
    assert hurried.time < patient.time
    assert farthest(hurried.shape.points, patient.shape.points) < 0.5e-3


@pytest.mark.slow
def test_tuned_mujoco_comes_to_rest_with_cables():
    for case in equilibrium.draw_cases()[:6]:
        rig = case.build_rig(equilibrium.TUNED)
        hurried = rig.relax([case.load_step])
        rig.options = replace(equilibrium.TUNED, still=1e-5)
        assert farthest(hurried.shape.points, rig.relax([case.load_step]).shape.points) < 0.5e-3
        careful = replace(equilibrium.TUNED, timestep=1e-3, armature_factor=10.0)
        shape = case.solve()
        where = case.build_rig(careful).relax([case.load_step]).shape
        if not where.is_shut.any() and not shape.is_shut.any():
            assert farthest(where.points, shape.points) < 0.5e-3


def test_cases_are_what_the_claim_says():
    cases = equilibrium.draw_cases()
    assert len(cases) == equilibrium.COUNT
    assert {int((case.pull > 0).sum()) for case in cases} == {1, 2}
    pulls = np.concatenate([case.pull[case.pull > 0] for case in cases])
    assert 0.02 <= pulls.min() < pulls.max() <= 0.08
    assert [case.tilt for case in cases] == [case.tilt for case in equilibrium.draw_cases()]


def test_claims_have_the_bars_they_promise(monkeypatch):
    """Each is measured with what it times replaced by known times."""
    given = iter([2e-5, 3e-3, 1e-3])
    times = lambda *calls, **_: [next(given) for _ in calls]  # noqa: E731
    for module in (rest, bending, equilibrium):
        monkeypatch.setattr(module, "time_in_turns", times)
    claim = rest.measure_rest_mujoco()
    assert (claim.ours, claim.other, claim.bar) == (2e-5, 3e-3, 50.0)
    given = iter([2e-5, 1e-4])
    assert rest.measure_rest_fsolve() == Claim(ours=2e-5, other=1e-4, bar=5.0)
    given = iter([1.0, 10.0, 1.0, 10.0])
    assert bending.measure_bend_single() == bending.measure_bend_batch() == Claim(ours=1.0, other=10.0, bar=10.0)
    monkeypatch.setattr(
        equilibrium, "draw_cases", lambda: [equilibrium.Case(pull=np.zeros(3), tilt=0.0, load=0.0, section=0)]
    )
    given = iter([1.0, 13.0, 2.0])
    assert equilibrium.measure_statics_mujoco() == Claim(ours=1.0, other=11.0, bar=10.0)


def test_every_claim_has_a_name_of_its_own():
    assert not set(CLAIMS) & set(PEERS)


def test_pyelasticas_rod_is_the_trunk():
    """It sags as far as our trunk with hinges, within what a rod differs from a chain by."""
    pytest.importorskip("elastica")
    seen, walls = elastica.swing()
    assert np.isfinite(seen).all()
    assert walls == sorted(walls)
    away = np.linalg.norm(seen[-1] - seen[-20], axis=0).max()
    assert away < 0.01 * elastica.CLOSE * PAPER.length


@pytest.mark.slow
def test_scipy_seeks_the_same_tip():
    for target in reach.draw_targets(3):
        tension = reach.fit_tensions(target)
        shape = reach.statics.solve(PAPER, tension=tension, theta_0=target.tilt, friction=0.0)
        assert farthest(shape.points[-1], target.tip) < reach.CLOSE


@pytest.mark.slow
def test_the_table_of_speeds(tmp_path, capsys):
    path = Path(__file__).parents[2] / "benchmarks" / "model_speed.py"
    spec = importlib.util.spec_from_file_location("model_speed", path)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert script.main(["--out", str(tmp_path)]) == 0
    figures = json.loads((tmp_path / "model_speed.json").read_text())
    assert min(figures["single_us"].values()) > 0
    assert figures["floors"]["bytes_written_per_shape"] == 8 * (2 * 18 + 17)  # x and y of the section ends, bends.
    rates = figures["batch_per_s"]
    assert rates["floor: memory written"] > rates["laws alone"]
    assert "million shapes/s" in capsys.readouterr().out
