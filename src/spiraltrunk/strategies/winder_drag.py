"""Compensation of winders whose drums turn with friction and drag, by the tensions that the strategy measures.

Drums hold a tension in a cable that pays out. A trunk that closes therefore bends less than planned, and the arm, which
follows the plan, draws the object towards the base. A slack trunk stays bent. Ideal winders hold no such tension: with
them `balance_drag` changes nothing, and `straighten` pulls only where the object bends the trunk.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Command, Observation

DRAG_LEAST, DRAG_MOST = 1.5, 12.0
"""Tension of a dorsal cable beyond the commanded one from which it is balanced, and up to which [N] (ours): slack ones
measure less, and drums that pay out hold up to 9 N on the twin. A larger reading is no drag."""
CLOSING = ("curl", "tighten", "try", "settle", "heft", "rise on")
"""Actions of the wraps in which the trunk closes, and tries the load."""
STRAIGHTENING = 0.2
"""Tension that straightens a slack trunk, over the largest of a cable [-] (ours): 12 N; drums hold some 4 N."""
BENT = 0.04
"""Length by which a dorsal cable is paid out from which a slack trunk counts as bent, over the stroke [-] (ours). With
ideal winders it is straight within a third of it."""


def balance_drag(command: Command, observation: Observation, action: str) -> Command:
    r"""The command of a closing trunk, its ventral tensions raised by as much as dorsal cables resist to pay out.

    With tensions :math:`T` measured and :math:`T_c` commanded, and the ventral-dorsal coordinate :math:`y` of a cable's
    direction, each ventral tension rises by :math:`\sum_d (T - T_c)\, y / \sum_v |y|`, which balances the moment of the
    dorsal cables about the neutral axis. In actions that are not of `CLOSING` the command stays as it is.
    """
    if action not in CLOSING:
        return command
    design = observation.task.design
    y, planned = design.cable_direction[:, 1], command.cable_tension
    drag = np.where(y > 0.0, observation.cable_tension - planned, 0.0)
    drag = np.where(drag < DRAG_LEAST, 0.0, np.minimum(drag, DRAG_MOST))
    if not drag.any():
        return command
    more = float(drag @ np.maximum(y, 0.0)) / float(np.maximum(-y, 0.0).sum())
    return replace(
        command, cable_tension=np.where(y < 0.0, np.minimum(planned + more, design.cable.tension_max), planned)
    )


def straighten(command: Command, observation: Observation) -> Command:
    """The command of a slack, hanging trunk, its dorsal cables pulled to their straight length while it is bent."""
    design = observation.task.design
    dorsal = design.cable_direction[:, 1] > 0.0
    if not (observation.cable_pull[dorsal] < -BENT * design.cable_stroke).any():
        return command
    pull = np.full(dorsal.size, np.inf) if command.cable_pull is None else command.cable_pull.copy()
    pull[dorsal] = np.minimum(pull[dorsal], 0.0)
    tension = np.where(dorsal, STRAIGHTENING * design.cable.tension_max, command.cable_tension)
    return replace(command, cable_tension=tension, cable_pull=pull)
