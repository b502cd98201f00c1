"""What the winders do in a run: shape by shape, with the slack of the cables made up for.

The paper makes up for the residual slack L_slack of a cable, which the fully wrapped trunk shows, evenly over the
steps: C = L_slack / N_steps and dL'_i = dL_i + C i (Methods, "Material Elasticity"). dL_i is read as what the cable has
been pulled in by up to step i, so that at the last step all of the slack has been made up for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics.shape import Shape

_PULLED = {"rest": (), "bend-dorsal": (0,), "bend-ventral": (1, 2), "twist": (0, 1)}
"""Cables that are pulled, from 0; the others are let out and carry nothing."""


@final
@dataclass(frozen=True, kw_only=True)
class Plan:
    """The shapes of one run, in order."""

    run: Run
    """The run."""
    amount: np.ndarray
    """What is pulled at each shape, as the model takes it, shape (n,) [m]."""
    change: np.ndarray
    """What each cable has been pulled in by since the straight trunk, by the paper's model, shape (n, n_cable) [m]."""
    told: np.ndarray
    """The same with slack made up for: what the winders are told, shape (n, n_cable) [m]."""
    is_pulled: np.ndarray
    """Cables that are pulled, shape (n_cable,) [bool]."""

    @property
    def pull(self) -> np.ndarray:
        """What the winders are told, not a number for cables that carry nothing, shape (n, n_cable) [m]."""
        return np.where(self.is_pulled, self.told, np.nan)


def build_plan(design: TrunkDesign, protocol: Protocol, run: Run) -> Plan:
    """The winders' lengths in a run.

    Raises:
        TakeError: where the trunk cannot be pulled so far, or has other cables.
    """
    if len(protocol.slack) != design.n_cable:
        allowed = f"{design.n_cable}, one a cable of {design.name!r}"
        raise TakeError(f"slack_mm has {len(protocol.slack)} numbers; allowed: {allowed}")
    amount = run.step * np.arange(run.n_shape)
    try:
        change = solve_reference(design, run, amount).cable_change
    except ModelError as error:
        raise TakeError(f"run {run.name!r} asks for what the design {design.name!r} cannot do: {error}") from None
    compensation = np.array(protocol.slack) / max(run.steps, 1)
    told = change + compensation * np.arange(run.n_shape)[:, None]
    is_pulled = np.isin(np.arange(design.n_cable), _PULLED[run.kind])
    return Plan(run=run, amount=amount, change=change, told=told, is_pulled=is_pulled)


def solve_reference(design: TrunkDesign, run: Run, amount: np.ndarray) -> Shape:
    """The paper's model of a run's shapes."""
    if run.kind == "bend-dorsal":
        return reference.bend_dorsal(design, amount, run.theta_0)
    if run.kind == "bend-ventral":
        return reference.bend_ventral(design, amount, run.theta_0)
    if run.kind == "twist":
        return reference.twist(design, run.first, amount, run.theta_0)
    return reference.rest(design, np.full(len(amount), run.theta_0))
