"""Notes of a calibration follow from what was fitted."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.workflows.calibrate.artifacts import _list_warnings


def make_run(kinds: tuple[str, ...]) -> SimpleNamespace:
    misfits = tuple(SimpleNamespace(kind=kind, take=f"{kind}.csv", registered_rms=1e-3) for kind in kinds)
    fit = SimpleNamespace(has_converged=True, misfits=misfits)
    found = SimpleNamespace(misfits=misfits, parameters=(), fit=fit, unsolved=0, design=PAPER)
    return SimpleNamespace(
        found=found, recordings=SimpleNamespace(fitted={}, held_out={}), recorded=SimpleNamespace(synthetic=())
    )


@pytest.mark.parametrize(
    ("kinds", "is_told"),
    [(("twist",), True), (("rest", "twist"), True), (("twist", "bend-dorsal"), False),
     (("twist", "bend-ventral"), False), (("rest", "bend-dorsal"), False)],
)  # fmt: skip
def test_a_twist_without_a_bending_is_told(kinds, is_told) -> None:
    """Its intervals are doubled (docs/validation/calibration.md)."""
    assert any("without a bending" in note for note in _list_warnings(make_run(kinds))) == is_told
