"""Joint limits as an active set: every joint bends within a cone, |q_i| <= limit, in any direction.

A joint of the active set (``pressed``) moves along the rim of its cone only: its rows (y, z) are rotated to (normal,
tangent), the normal one is held, and the tangent's curvature grows by the reaction times that of the rim.
`model.kinematics.joint_limits` has the limit for arrays of planar bends.
"""

from __future__ import annotations

import math

from spiraltrunk.model.statics.kernels import compiled
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.laws.joint_rotation import bend_size

NEARLY = 5e-4
"""Angle short of the limit at which faces count as touching [rad]: the smoothing of the gaps keeps joints that open."""


@compiled
def is_shut(angle, limit):
    """Whether the faces touch at a joint whose sections enclose ``angle``."""
    return angle > limit - NEARLY


@compiled
def scale_to_limit(bend, kind, limit, rim):
    """Scale a bend to the limit, in place."""
    for _ in range(20):
        size = bend_size(bend, kind, rim)
        along = rim[0] * bend[0] + rim[1] * bend[1]
        scale = 1.0 + (limit - size) / along
        bend[0] *= scale
        bend[1] *= scale
        if abs(scale - 1.0) < 1e-15:
            return


@compiled
def project_to_limits(q, trunk, rim):
    """Scale every bend past the limit back to it, in place."""
    for i in range(q.shape[0]):
        if _is_bent(q, i, trunk.limit) and bend_size(q[i], trunk.kind[i], rim) > trunk.limit:
            scale_to_limit(q[i], trunk.kind[i], trunk.limit, rim)


@compiled
def is_at_limit(q, i, trunk, rim):
    """Whether joint i is at its limit; ``rim`` receives the derivatives of `bend_size` there."""
    return _is_bent(q, i, trunk.limit) and bend_size(q[i], trunk.kind[i], rim) >= trunk.limit * (1 - 1e-12)


@compiled
def _is_bent(q, i, limit):
    """Whether a joint is bent beyond half its limit, so that the bend has a direction."""
    return q[i, 0] * q[i, 0] + q[i, 1] * q[i, 1] > 0.25 * limit * limit


@compiled
def reduce(q, trunk, work, system):
    """Copy the equations of ``work`` to ``system``; joints pressed against their limit form the active set."""
    trunk, work, system = by_address(trunk), by_address(work), by_address(system)
    nd, rim = work.first.shape[1], system.rim
    for i in range(q.shape[0]):
        for a in range(nd):
            system.gradient[i * nd + a] = work.gradient[i, a]
        for c in range(work.gap.shape[1]):
            for a in range(nd):
                system.slopes[c, i * nd + a] = work.slope[i, c, a]
    for i in range(q.shape[0]):
        system.pressed[i], system.reaction[i] = False, 0.0
        if is_at_limit(q, i, trunk, rim):
            steep = rim[0] * rim[0] + rim[1] * rim[1]
            outward = -(rim[0] * work.gradient[i, 0] + rim[1] * work.gradient[i, 1]) / steep
            if outward >= 0:
                system.reaction[i] = outward
                activate_limit(i, trunk, work, system)


@compiled
def activate_limit(i, trunk, work, system):
    """Add joint i to the active set and reduce its equations; ``system.rim`` holds the rim's derivatives."""
    hessian, gradient, slopes, rim = work.hessian, system.gradient, system.slopes, system.rim
    nd = work.first.shape[1]
    y, z = i * nd, i * nd + 1
    steep = math.sqrt(rim[0] * rim[0] + rim[1] * rim[1])
    cosine, sine = rim[0] / steep, rim[1] / steep
    system.normal[i, 0], system.normal[i, 1] = cosine, sine
    for column in range(y):
        hessian[z, column] = cosine * hessian[z, column] - sine * hessian[y, column]
        hessian[y, column] = 0.0
    for row in range(z + 1, hessian.shape[0]):
        hessian[row, z] = cosine * hessian[row, z] - sine * hessian[row, y]
        hessian[row, y] = 0.0
    bend = hessian[y, y] * sine * sine + hessian[z, z] * cosine * cosine - 2 * hessian[z, y] * sine * cosine
    hessian[z, z] = bend + system.reaction[i] * rim[2]
    hessian[z, y], hessian[y, y] = 0.0, trunk.stiffness[i, 0]
    gradient[z], gradient[y] = cosine * gradient[z] - sine * gradient[y], 0.0
    for c in range(slopes.shape[0]):
        slopes[c, z], slopes[c, y] = cosine * slopes[c, z] - sine * slopes[c, y], 0.0
    system.pressed[i] = True


@compiled
def activate_outward_limits(q, trunk, work, system):
    """Add the joints at their limit that the step would move past it to the active set; whether there are any."""
    found, nd, rim = False, work.first.shape[1], system.rim
    for i in range(q.shape[0]):
        is_free = not system.pressed[i] and is_at_limit(q, i, trunk, rim)
        if is_free and rim[0] * system.step[i * nd] + rim[1] * system.step[i * nd + 1] > 0:
            activate_limit(i, trunk, work, system)
            found = True
    return found


@compiled
def move(q, trunk, system, share):
    """``q`` plus ``share`` of the reduced step, projected to the joint limits, into ``system.trial``."""
    step, out = system.step, system.trial
    nd = step.shape[0] // q.shape[0]
    for i in range(q.shape[0]):
        if system.pressed[i]:
            tangent = share * step[i * nd + 1]
            out[i, 0] = q[i, 0] - system.normal[i, 1] * tangent
            out[i, 1] = q[i, 1] + system.normal[i, 0] * tangent
            scale_to_limit(out[i], trunk.kind[i], trunk.limit, system.rim)
        else:
            out[i, 0] = q[i, 0] + share * step[i * nd]
            out[i, 1] = q[i, 1] + share * step[i * nd + 1]
        if nd == 3:
            out[i, 2] = q[i, 2] + share * step[i * nd + 2]
    project_to_limits(out, trunk, system.rim)
