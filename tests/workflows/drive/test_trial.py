"""Strategies, unchanged, on the twin from homing to the verdict."""

import pytest

from spiraltrunk import strategies
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.drive.trial import run_on_twin


def _run(name, **options):
    return run_on_twin(PAPER, parse_object(strategies.get(name).objects[0]), strategy=name, **options)


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_a_kick_succeeds_on_the_twin_and_its_log_is_read_again(tmp_path):
    done = _run("kick", log=tmp_path / "kick.mcap")
    assert done.trial.verdict.success, done.trial.verdict.reason
    assert done.snapshot.faults == ()
    assert len(done.trial.plant.trace) == len(done.trial.log.observations), "what follows the run is not judged"
    assert 0.0 < done.homing < 15.0
    assert (tmp_path / "kick.mcap").stat().st_size > 0


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("name", strategies.NAMES)
def test_no_strategy_raises_a_false_alarm(name):
    """Nothing is wrong with the twin: whatever the strategy achieves, no watch may stop it."""
    done = _run(name)
    print(f"{name}: {done.trial.verdict.reason}")
    assert [fault.text for fault in done.snapshot.faults] == []


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize(("name", "seed"), [("sweep", 0), ("wrap-oblique", 2), ("wrap-vertical", 3)])
def test_wraps_close_as_planned_against_the_drag_of_the_drums(name, seed):
    """Without `strategies.winder_drag` the object was drawn to the housing, or wrapped by a bent trunk."""
    verdict = _run(name, seed=seed).trial.verdict
    assert verdict.success, verdict.reason
