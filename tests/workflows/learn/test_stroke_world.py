"""Worlds of strokes: a try leaves the world as it was, and rewards order outcomes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.strategies.policy.description import Layers, PolicyDescription
from spiraltrunk.strategies.policy.stroke_strategy import INPUTS, OUTPUTS, StrokeStrategy
from spiraltrunk.strategies.push.kick import Kick
from spiraltrunk.workflows.learn import stroke_world
from spiraltrunk.workflows.learn.stroke_world import StrokeWorld, measure_outcome

ABOUT = PolicyDescription(
    control_mode="stroke", inputs=INPUTS, outputs=OUTPUTS, networks={"action": Layers(sizes=(12, 6))}, n_cable=3,
    job="kick", support="ground", orientation="upright", holds="nothing", needs_camera=True, objects=Kick.objects,
    position=Kick.position, push=Kick.push,
)  # fmt: skip


@dataclass
class Verdict:
    success: bool
    reason: str


@pytest.mark.slow
def test_equal_strokes_in_one_world_end_equally() -> None:
    world = StrokeWorld(presets.PAPER, "box-80", StrokeStrategy("stroke", ABOUT, {"action": None}), 3, timestep=2e-3)
    first, away = world.strike(np.zeros(6)), world.strike(np.array([1.0, 1.0, 1.0, 1.0, -1.0, -1.0]))
    again = world.strike(np.zeros(6))
    assert first == again
    assert away != first


@dataclass
class Seen:
    """What `compute_path` would give: displacement along and across, and the line."""

    along: tuple[float, ...]
    aside: tuple[float, ...] = field(default=(0.0, 0.0))


@pytest.mark.parametrize(
    ("better", "worse"),
    [
        ((Seen((0.0, 0.16)), Verdict(True, "success")), (Seen((0.0, 0.16)), Verdict(False, "not at rest"))),
        ((Seen((0.0, 0.12)), Verdict(False, "went 12 cm")), (Seen((0.0, 0.05)), Verdict(False, "went 5 cm"))),
        (
            (Seen((0.0, 0.12)), Verdict(False, "went 12 cm")),
            (Seen((0.0, 0.12), (0.0, 0.1)), Verdict(False, "went 12 cm")),
        ),
        ((Seen((0.0, 0.12)), Verdict(False, "went 12 cm")), (Seen((0.0, 0.12)), Verdict(False, "the arm passed"))),
    ],
)
def test_rewards_order_outcomes(
    monkeypatch: pytest.MonkeyPatch, better: tuple[Seen, Verdict], worse: tuple[Seen, Verdict]
) -> None:
    rewards = []
    for seen, verdict in (better, worse):
        path = np.array(seen.along), np.array(seen.aside), 0.15
        monkeypatch.setattr(stroke_world, "compute_path", lambda evidence, path=path: path)
        monkeypatch.setattr(stroke_world, "evaluate_kick", lambda evidence, verdict=verdict: verdict)
        rewards.append(measure_outcome(None).reward)
    assert rewards[0] > rewards[1]
