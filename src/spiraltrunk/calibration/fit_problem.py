"""Measured shapes and the states that they were measured in: prediction, derivatives, and chains of residuals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.noise_model import LEAST_DISCREPANCY, LEAST_TWIST, TWIST_POWER, Block, compute_levers
from spiraltrunk.calibration.parameters import apply_parameters
from spiraltrunk.calibration.predict_states import (
    Equilibria,
    State,
    compute_step,
    is_one_increment,
    place_markers,
    predict_statics,
    select_states,
)
from spiraltrunk.calibration.sensitivities import Sensitivities, by_parameters
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError

_FEW_STATES = 4
"""Chains of fewer states are not split."""


@final
@dataclass(frozen=True, kw_only=True)
class FitProblem:
    """Measured shapes and the states that they were measured in."""

    design: TrunkDesign
    """The trunk, its gripper's mass in the last section."""
    states: tuple[State, ...]
    """What the cables were brought to."""
    marker_offset: np.ndarray
    """Distance of each section's marker from its proximal joint, shape (n_section,) [m]."""
    measured: np.ndarray
    """Mean of the takes; not a number where unseen, shape (n_state, n_section, 3) [m]."""
    count: np.ndarray
    """Takes that each point is the mean of, shape (n_state, n_section) [-]."""

    def predict(self, values: np.ndarray) -> tuple[Equilibria, np.ndarray]:
        """Equilibria with a parameter vector, and the markers, shape (n_state, n_section, 3) [m]."""
        design, winders = apply_parameters(self.design, values)
        equilibria = predict_statics(design, self.states, winders)
        return equilibria, place_markers(design, equilibria.points, self.marker_offset)

    def differentiate(self, values: np.ndarray, equilibria: Equilibria, softness: float) -> np.ndarray:
        """Jacobian of the markers with pressed joints of a softness, shape (n_parameter, n_state, n_section, 3)."""
        design, winders = apply_parameters(self.design, values)
        each: list[Sensitivities] = []
        for shape, state, length in zip(equilibria.shapes, self.states, equilibria.length, strict=True):
            each.append(
                by_parameters(
                    design, shape, theta_0=state.theta_0, length=length, compliance=winders.compliance,
                    softness=softness, before=None if state.before < 0 else each[state.before],
                    is_direct=state.before >= 0 and is_one_increment(state, self.states),
                )
            )  # fmt: skip
        points = np.stack([one.points for one in each], axis=1)
        return place_markers(design, points, self.marker_offset)


def split_half(problem: FitProblem, odd: int) -> FitProblem:
    """Every other state of each chain, each reached in one increment, and all states at rest.

    Pulled ever further a cable slides at every hole, and how finely it was pulled does not matter.
    """
    chains = np.array([state.chain for state in problem.states])
    own = [np.flatnonzero(chains == chain) for chain in np.unique(chains)]
    kept = sorted(s for part in own for s in (part if len(part) < _FEW_STATES else part[odd::2]).tolist())
    return replace(
        problem, states=select_states(problem.states, kept), measured=problem.measured[kept], count=problem.count[kept]
    )


def build_blocks(problem: FitProblem, predicted: np.ndarray) -> list[Block]:
    """The seen points, chain by chain."""
    stroke = np.zeros(len(problem.states))
    for i, state in enumerate(problem.states):
        stroke[i] = (0.0 if state.before < 0 else stroke[state.before]) + compute_step(state, problem.states)
    seen = np.isfinite(problem.measured).all(axis=-1)
    chains = np.array([state.chain for state in problem.states])
    parts = [np.argwhere(seen & (chains == chain)[:, None]) for chain in np.unique(chains)]
    levers = {is_twist: _compute_levers(problem, is_twist) for is_twist in (False, True)}
    blocks = []
    for s, n in (at.T for at in parts if len(at)):
        is_twist = problem.states[s[0]].kind == "twist"
        blocks.append(
            Block(
                points=predicted[s, n], at=np.stack([s, n], axis=-1), lever=levers[is_twist][n], stroke=stroke[s],
                weight=problem.count[s, n].astype(float),
                least_discrepancy=LEAST_TWIST if is_twist else LEAST_DISCREPANCY,
            )
        )  # fmt: skip
    if not blocks:
        raise ModelError("no point was seen in the takes that are fitted; allowed: at least one shape")
    return blocks


def _compute_levers(problem: FitProblem, is_twist: bool) -> np.ndarray:
    """Displacement of all markers by the errors of the bends, of `noise_model.compute_levers`."""
    design = problem.design
    start = np.cumsum(design.section_length) - design.section_length
    spread = design.scale[:-1] ** -(TWIST_POWER if is_twist else 0.0)
    return compute_levers((start + problem.marker_offset) / design.length, start[1:] / design.length, spread)
