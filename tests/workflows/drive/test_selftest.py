"""Every fault of the self-test is noticed in time, and safe in time; each test prints its figures."""

from __future__ import annotations

import math

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.workflows.drive import selftest
from spiraltrunk.workflows.drive.selftest import SCENARIOS, FaultResult, Scenario, run_scenario, run_selftest

pytestmark = pytest.mark.usefixtures("prepared_once")


@pytest.fixture(scope="module")
def nominal() -> float:
    return selftest._measure_nominal(PAPER, 0)


def show(name: str, result: FaultResult) -> None:
    times = [math.nan if time is None else 1e3 * time for time in (result.detected, result.safe)]
    print(
        f"{name}: noticed after {times[0]:.0f} ms as {result.cause}, safe after {times[1]:.0f} ms, "
        f"{1e3 * result.wound:.1f} mm wound in, tracking {result.tracking:.2f}, warnings {len(result.warnings)}"
    )


LATER = {"duplicate", "reorder", "delay", "frame_loss_1_percent", "20_missed_cycles", "encoder_wrap"}
"""Slow, as the fast tests try harsher faults of the bus, and another fault of the encoder."""

MARKED = [
    pytest.param(name, marks=pytest.mark.slow) if scenario.has_cells or name in LATER else name
    for name, scenario in SCENARIOS.items()
]
"""Each fault; those of load cells are tried by faster tests beside the driver."""


@pytest.mark.parametrize("name", MARKED)
def test_what_must_happen_happens(name, nominal):
    result = run_scenario(PAPER, SCENARIOS[name], seed=0, nominal=nominal)
    show(name, result)
    assert result.holds
    assert (result.cause == FaultKind.TANGLED_DRUM.value) == (name == "tangled_drum")


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_it_happens_with_other_slack_and_other_faults_too(seed):
    results = run_selftest(PAPER, seed=seed)
    for name, result in results.items():
        show(name, result)
    assert [name for name, result in results.items() if not result.holds] == []


UNCERTAIN = {FaultKind.SLACK.value, FaultKind.CABLE_SLIP.value, FaultKind.CABLE_LENGTHS.value}
"""Kinds that name every cause that looks alike."""


@pytest.mark.parametrize(
    ("fault", "cable"),
    [
        pytest.param(
            fault, cable, marks=[] if (fault, cable) in {("cable_slip", 1), ("cable_break", 2)} else [pytest.mark.slow]
        )
        for fault in ("cable_slip", "cable_break")
        for cable in (0, 1, 2)
    ],
)
def test_each_cable_is_watched(fault, cable, nominal):
    scenario = Scenario(fault=fault, settings={"cable": cable}, bar=selftest.CABLE_BAR, is_length_enough=True)
    result = run_scenario(PAPER, scenario, seed=5, nominal=nominal)
    show(f"{fault} of cable {cable + 1}", result)
    assert result.holds
    assert result.cause in UNCERTAIN


@pytest.mark.parametrize(
    ("factor", "strength", "cable"),
    [
        pytest.param(*way, cable, marks=[] if cable == 0 else [pytest.mark.slow])
        for way in ((-1.0, 2.0), (-1.0, 0.0), (1.3, 1.0))
        for cable in (0, 1, 2)
    ],
)
def test_a_tangled_drum_is_told_as_tangled_or_as_what_looks_alike(factor, strength, cable, nominal):
    """Loaded, one that winds the wrong way is told as tangled but for a burst of cable that comes in before.

    While one winds a little more, others may stand when that is noticed: that is told as a stall, and what else it may
    be.
    """
    settings = {"cable": cable, "factor": factor}
    result = run_scenario(
        PAPER, Scenario(fault="tangled_drum", settings=settings, strength=strength), seed=5, nominal=nominal
    )  # fmt: skip
    show(f"tangled drum {cable + 1}, factor {factor:g}", result)
    may_stand = {FaultKind.STALL.value} if factor > 0.0 else set()
    assert result.cause in {FaultKind.TANGLED_DRUM.value, *UNCERTAIN, *may_stand}


@pytest.mark.slow
def test_a_slip_that_is_too_short_goes_on_unnoticed(nominal):
    """SAFETY.md says so."""
    scenario = Scenario(fault="cable_slip", settings={"length": 0.002}, is_stop=False)
    assert run_scenario(PAPER, scenario, seed=0, nominal=nominal).holds


RESULT = FaultResult(
    detected=0.1, safe=0.15, cause="stall", bar=0.2, holds=True, tracking=math.nan, wound=0.0, warnings=()
)
"""A fault that was noticed and ended safe."""


@pytest.mark.parametrize(
    ("scenario", "changes", "holds"),
    [
        ({"bar": 0.2}, {}, True),
        ({"bar": 0.05}, {}, False),
        ({"bar": 0.05, "is_length_enough": True}, {"wound": 0.002}, True),
        ({"bar": 0.05, "is_length_enough": True}, {"wound": 0.004}, False),
        ({"bar": 0.2}, {"safe": 0.21}, False),
        ({"bar": 0.2}, {"safe": None}, False),
        ({"bar": 0.2}, {"detected": None, "cause": None}, False),
        ({"bar": 0.2, "is_warned": True}, {}, False),
        ({"bar": 0.2, "is_warned": True}, {"warnings": ("hot",)}, True),
        ({"bar": 0.14, "is_safe_bar": True}, {}, False),
        ({"bar": 0.16, "is_safe_bar": True}, {}, True),
        ({"is_stop": False}, {}, False),
        ({"is_stop": False, "may_stop": True}, {}, True),
        ({"is_stop": False, "may_stop": True}, {"safe": 0.21}, False),
        ({"is_stop": False}, {"cause": None, "detected": None, "tracking": 1.9}, True),
        ({"is_stop": False}, {"cause": None, "detected": None, "tracking": 2.1}, False),
    ],
)
def test_the_verdict_on_a_fault(scenario, changes, holds):
    result = FaultResult(**{**{name: getattr(RESULT, name) for name in RESULT.__dataclass_fields__}, **changes})
    assert selftest._holds(Scenario(fault="stall", **scenario), result) == holds
