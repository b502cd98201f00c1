"""Runs that the model does not express are named, and others are not."""

from types import SimpleNamespace

import pytest

from spiraltrunk.calibration.identifiability import list_misfitted
from spiraltrunk.design.presets import PAPER


@pytest.mark.parametrize(
    ("rms_mm", "expected"),
    [((0.1, 0.2, 1.7), [2]), ((0.1, 0.2, 0.9), []), ((0.8, 0.9, 2.0), []), ((5.0,), []), ((0.4, 6.0), [1])],
)
def test_a_run_far_above_the_others_and_a_millimetre_is_misfitted(rms_mm, expected):
    misfits = tuple(SimpleNamespace(registered_rms=1e-3 * value) for value in rms_mm)
    found = list_misfitted(SimpleNamespace(misfits=misfits, design=PAPER))
    assert [misfits.index(run) for run in found] == expected
