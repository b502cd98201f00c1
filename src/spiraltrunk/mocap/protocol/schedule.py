"""Schedule of a run: the winders' lengths, shape by shape, with the slack of the cables compensated.

The paper compensates the residual slack L_slack of a cable, measured on the fully wrapped trunk, evenly over the steps:
C = L_slack / N_steps and dL'_i = dL_i + C i (Methods, "Material Elasticity"). dL_i is read as the length pulled in up
to step i, so that the last step has compensated all of the slack.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics.shape import Shape


@final
@dataclass(frozen=True, kw_only=True)
class Schedule:
    """The shapes of one run, in order."""

    run: Run
    amount: np.ndarray
    """Pull at each shape, as the models take it, shape (n,) [m]."""
    change: np.ndarray
    """Length pulled in since the straight trunk, by the paper's model, shape (n, n_cable) [m]."""
    slack: tuple[float, ...]
    """Slack of each cable that is compensated by the last shape, (n_cable,) [m]."""
    commanded: np.ndarray
    """The same with slack compensated: the winders' commands, shape (n, n_cable) [m]."""
    is_pulled: np.ndarray
    """Cables that are pulled, shape (n_cable,) [bool]; the others pay out freely."""

    @property
    def pull(self) -> np.ndarray:
        """Commanded lengths, not a number for cables that pay out freely, shape (n, n_cable) [m]."""
        return np.where(self.is_pulled, self.commanded, np.nan)


def build_schedule(design: TrunkDesign, protocol: Protocol, run: Run) -> Schedule:
    """The winders' lengths in a run.

    Raises:
        TakeError: where the trunk cannot be pulled so far, or has another number of cables.
    """
    slack = protocol.slack if any(protocol.slack) else (0.0,) * design.n_cable
    if len(slack) != design.n_cable:
        allowed = f"{design.n_cable}, one a cable of {design.name!r}"
        raise TakeError(f"slack_mm of the protocol has {len(slack)} numbers; allowed: {allowed}")
    amount = run.step * np.arange(run.n_shape)
    try:
        change = solve_reference(design, run, amount).cable_change
    except ModelError as error:
        raise TakeError(f"run {run.name!r} asks for what the design {design.name!r} cannot do: {error}") from None
    compensation = np.array(slack) / max(run.steps, 1) * np.arange(run.n_shape)[:, None]
    return Schedule(
        run=run, amount=amount, change=change, slack=slack, commanded=change + compensation,
        is_pulled=_find_pulled(design, run.kind),
    )  # fmt: skip


def _find_pulled(design: TrunkDesign, kind: str) -> np.ndarray:
    """Cables that the models pull in a run of this kind, shape (n_cable,) [bool]."""
    if kind == "bend-ventral":
        return ventral_cables(design)
    first = {"rest": 0, "bend-dorsal": 1, "twist": 2}[kind]
    return np.arange(design.n_cable) < first


def solve_reference(design: TrunkDesign, run: Run, amount: np.ndarray) -> Shape:
    """A run's shapes by the paper's model."""
    if run.kind == "bend-dorsal":
        return reference.bend_dorsal(design, amount, run.theta_0)
    if run.kind == "bend-ventral":
        return reference.bend_ventral(design, amount, run.theta_0)
    if run.kind == "twist":
        return reference.twist(design, run.first, amount, run.theta_0)
    return reference.rest(design, np.full(len(amount), run.theta_0))
