"""Residuals of a shape against its target, with Jacobian: section ends, tip direction, a circle to touch.

Residuals in metres, in this order: the section ends' distances in x, y, z; the tip's direction; and per section the gap
between its outer surface and the circle, and the distance of its end from the circle's plane.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.inverse.kernels import compiled
from spiraltrunk.model.statics.kernels.laws.gravity_load import spin
from spiraltrunk.model.statics.kernels.newton_calls import solve_slopes

FLAT = 3.0
"""How much more the distance of a touching section from the circle's plane weighs than its gap [-]."""
NEAR_FLAT = 1.0
"""The same for the other sections [-]."""


class Targets(NamedTuple):
    """What is wanted, one row a target; a weight of 0 leaves a part out."""

    point: np.ndarray
    """Section ends, shape (b, n_section, 3) [m]."""
    weight: np.ndarray
    """Their weights, shape (n_section,) [-]."""
    heading: np.ndarray
    """Unit vector of the last section's axis, shape (b, 3) [-]."""
    turn: float
    """Weight of that [m]."""
    circle: np.ndarray
    """Centre, unit normal and radius of the circle, shape (b, 7) [m], [-], [m]."""
    touch: np.ndarray
    """Weights of the gaps between sections and circle, shape (b, n_section) [-]."""
    deep: float
    """Weight of a section's depth in the circle [-]; 0 where there is no circle."""
    hull: np.ndarray
    """Sections' radius and the outer surface's start and end along the axis, shape (n_section, 3) [m]."""


@compiled
def circle_gap(n, b, points, heads, targets):
    """Gap between section n's outer surface and the circle [m]; negative inside.

    Also its slopes by the centre's place along the axis and by its distance from the axis, and that place and distance.
    """
    radius, start, end = targets.hull[n]
    along, square = 0.0, 0.0
    for x in range(3):
        to = targets.circle[b, x] - (points[n - 1, x] if n > 0 else 0.0)
        along += to * heads[n, x]
        square += to * to
    across = math.sqrt(max(square - along * along, 1e-18))
    beside = along - min(max(along, start), end)
    above = across - radius
    if beside == 0.0 or above <= 0.0:
        if above <= 0.0 and abs(beside) > -above:  # Beside the section, not in it.
            return abs(beside) - targets.circle[b, 6], (1.0 if beside > 0 else -1.0), 0.0, along, across
        return above - targets.circle[b, 6], 0.0, 1.0, along, across
    away = math.sqrt(above * above + beside * beside)
    return away - targets.circle[b, 6], beside / away, above / away, along, across


@compiled
def evaluate_residual(b, points, heads, targets, out):
    """Residuals of target b into ``out``; returns half the sum of their squares [m^2]."""
    count, total = points.shape[0], 0.0
    for n in range(count):
        if targets.weight[n] != 0.0:
            for x in range(3):
                out[3 * n + x] = targets.weight[n] * (points[n, x] - targets.point[b, n, x])
                total += out[3 * n + x] * out[3 * n + x]
    if targets.turn != 0.0:
        for x in range(3):
            out[3 * count + x] = targets.turn * (heads[count - 1, x] - targets.heading[b, x])
            total += out[3 * count + x] * out[3 * count + x]
    if targets.deep != 0.0:
        for n in range(count):
            gap, off = circle_gap(n, b, points, heads, targets)[0], 0.0
            for x in range(3):
                off += (points[n, x] - targets.circle[b, x]) * targets.circle[b, 3 + x]
            out[3 * count + 3 + n] = gap * (targets.deep if gap < 0 else targets.touch[b, n])
            out[4 * count + 3 + n] = (FLAT if targets.touch[b, n] != 0.0 else NEAR_FLAT) * off
            total += out[3 * count + 3 + n] ** 2 + out[4 * count + 3 + n] ** 2
    return 0.5 * total


@compiled
def residual_jacobian(b, points, heads, ends, turns, targets, out):
    """Rates of the residuals into ``out``, with the section ends moving at ``ends`` and the sections at ``turns``."""
    count = points.shape[0]
    for n in range(count):
        if targets.weight[n] != 0.0:
            for x in range(3):
                out[3 * n + x] = targets.weight[n] * ends[n, x]
    if targets.turn != 0.0:
        swing = turn_head(turns[count - 1], heads[count - 1])
        for x in range(3):
            out[3 * count + x] = targets.turn * swing[x]
    if targets.deep != 0.0:
        for n in range(count):
            gap, by_along, by_across, place, distance = circle_gap(n, b, points, heads, targets)
            swing, along, square, off = turn_head(turns[n], heads[n]), 0.0, 0.0, 0.0
            for x in range(3):
                to = targets.circle[b, x] - (points[n - 1, x] if n > 0 else 0.0)
                back = ends[n - 1, x] if n > 0 else 0.0
                along += to * swing[x] - back * heads[n, x]
                square -= to * back
                off += ends[n, x] * targets.circle[b, 3 + x]
            across = (square - place * along) / distance
            share = targets.deep if gap < 0 else targets.touch[b, n]
            out[3 * count + 3 + n] = share * (by_along * along + by_across * across)
            out[4 * count + 3 + n] = (FLAT if targets.touch[b, n] != 0.0 else NEAR_FLAT) * off


@compiled
def turn_head(turn, head):
    """Rate of a unit vector that turns: the cross product."""
    return (
        turn[1] * head[2] - turn[2] * head[1], turn[2] * head[0] - turn[0] * head[2],
        turn[0] * head[1] - turn[1] * head[0],
    )  # fmt: skip


@compiled
def place_sections(work, length, points, heads):
    """Section ends and axes of the placed chain, shapes (n_section, 3)."""
    for x in range(3):
        end = 0.0
        for n in range(length.shape[0]):
            heads[n, x] = work.frames[n, x, 0]
            end += length[n] * heads[n, x]
            points[n, x] = end


@compiled
def tension_sensitivity(q, case, work, system, rates):
    """Sensitivity -H^-1 dg/dT of the bends to each tension (H reduced), into ``rates`` (n_cable, n_joint x nd)."""
    nd = work.first.shape[1]
    solve_slopes(q, case, work, system, rates)
    for c in range(rates.shape[0]):
        for row in range(rates.shape[1]):
            rates[c, row] = -rates[c, row]
        turn_back(rates[c], system, nd)


@compiled
def turn_back(step, system, nd):
    """A step of the reduced equations in the joints' own axes, in place."""
    for i in range(system.pressed.shape[0]):
        if system.pressed[i]:
            tangent = step[i * nd + 1]
            step[i * nd] = -system.normal[i, 1] * tangent
            step[i * nd + 1] = system.normal[i, 0] * tangent


@compiled
def chain_rates(rates, work, length, ends, turns):
    """Motion of the section ends and turning of the sections at the bends' rates, shapes (n_section, 3)."""
    nd = work.first.shape[1]
    for x in range(3):
        ends[0, x], turns[0, x] = 0.0, 0.0
    for i in range(work.first.shape[0]):
        for x in range(3):
            turns[i + 1, x] = turns[i, x]
        for a in range(nd):
            rate = rates[i * nd + a]
            if rate != 0.0:
                spun = spin(work.first[i, a], work.rotation[i], work.frames[i])
                for x in range(3):
                    turns[i + 1, x] += rate * spun[x]
        swing = turn_head(turns[i + 1], work.frames[i + 1, :, 0])
        for x in range(3):
            ends[i + 1, x] = ends[i, x] + length[i + 1] * swing[x]


@compiled
def gap_rows(points, heads, targets, out):
    """Gap between every section's outer surface and the circle of its row, into ``out`` (b, n_section) [m]."""
    for b in range(out.shape[0]):
        for n in range(out.shape[1]):
            out[b, n] = circle_gap(n, b, points[b], heads[b], targets)[0]
