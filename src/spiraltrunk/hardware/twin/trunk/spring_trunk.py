"""The trunk as two degrees of freedom: fast enough for hours of a driver's operation."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import final

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.trunk.anchor import CABLE_DAMPING_TIME
from spiraltrunk.hardware.twin.trunk.trunk_curl import POINTS, TrunkCurl, compute_curl
from spiraltrunk.model.kinematics.frames import base_orientation

_Row = tuple[float, ...]


@final
class SpringTrunk(CableLoad):
    """Stand-in for the simulated trunk: it curls in one plane at a time, with weight, inertia and damping.

    State is the curl b of `trunk_curl`, shape (2,) [m]; cable c is elongated by e_c = wound_c - l_c(b) and cannot push:

        M b'' + C(s) b' = -dU/db + sum_c T_c dl_c/db,   T_c = max(0, k_c e_c + k_c tau de_c/dt),   |b| <= stroke,

    with U the elastic and the potential energy. A step is backward Euler, linearised once (Rosenbrock), where the
    Hessian of the weight is left out; at the stroke, where every gap is shut, the outward speed ends. Torsion, friction
    in the holes, contact and shapes with two bends are left out, too: `statics` and the simulation have them.
    """

    def __init__(
        self,
        design: TrunkDesign,
        *,
        theta_0: float = math.pi / 2,
        roll: float = 0.0,
        cable_damping_time: float = CABLE_DAMPING_TIME,
    ) -> None:
        """A straight trunk at rest.

        Args:
            design: the trunk.
            theta_0: angle of its base axis below the horizontal [rad].
            roll: rotation about the base axis [rad].
            cable_damping_time: damping of a cable over its stiffness, tau [s].
        """
        self._stroke = design.cable_stroke
        self._directions = [(float(y), float(z)) for _, y, z in design.cable_direction]
        self._curl = compute_curl(design)
        self._per_step, self._rows = 1.0 / self._curl.step, _interleave(self._curl)
        down = base_orientation(float(theta_0), float(roll)).T @ (0.0, -GRAVITY, 0.0)
        self._down: tuple[float, float, float] = (float(down[0]), float(down[1]), float(down[2]))
        self._curled, self._velocity = (0.0, 0.0), (0.0, 0.0)
        self._before: Sequence[float] | None = None
        self._damping_time = cable_damping_time
        self._look()

    @property
    def curl(self) -> tuple[float, float]:
        """Curl b towards cable 1's direction y and towards z [m]."""
        return self._curled

    @property
    def taken(self) -> tuple[float, ...]:
        """Length that the trunk's shape takes up of each cable since straight [m]."""
        return tuple(length for length, _, _ in self._cables)

    def advance(self, wound: Sequence[float], stiffness: Sequence[float], dt: float) -> Sequence[float]:
        """See `CableLoad.advance`; the tension is that at the end of the step.

        Raises:
            DriveError: where the number of cables is not the design's.
        """
        if len(wound) != len(self._directions):
            raise DriveError(f"{len(wound)} cables on the drums; allowed: the trunk's {len(self._directions)}")
        rate, before = self._damping_time / dt, self._before or wound
        self._before = tuple(wound)
        damped = [w + rate * (w - w0) for w, w0 in zip(wound, before, strict=True)]
        cables = self._cables
        self._move(wound, damped, stiffness, dt)
        self._look()
        tension = []
        for i, (taken, _, _) in enumerate(self._cables):
            is_taut = wound[i] > taken
            stretch = damped[i] - taken - rate * (taken - cables[i][0])
            tension.append(stiffness[i] * stretch if is_taut and stretch > 0.0 else 0.0)
        return tension

    def energy(self) -> float:
        """Kinetic, elastic and potential energy without the cables' [J]; the latter two are 0 when straight."""
        s, curl, (x, y, z) = self._size, self._curl, self._down
        cells = max(0, math.ceil(s * self._per_step))
        steps = [min(self._curl.step, s - i * self._curl.step) for i in range(cells)]
        elastic = sum(
            width * (curl.force[i] + 0.5 * (curl.force[i + 1] - curl.force[i]) * width * self._per_step)
            for i, width in enumerate(steps)
        )
        _, _, _, _, axial, lateral = self._values
        kinetic = 0.5 * curl.mass * (self._velocity[0] ** 2 + self._velocity[1] ** 2)
        weight = (axial - curl.axial[0]) * x + lateral * (self._curled[0] * y + self._curled[1] * z)
        return kinetic + elastic - weight

    def _look(self) -> None:
        """Tables, forces and cables of the present curl."""
        b, e = self._curled
        s = self._size = math.sqrt(b * b + e * e)
        at = s * self._per_step
        i = min(int(at), POINTS - 2)
        part, (row, slope) = at - i, self._rows[i]
        self._values = [value + part * rise for value, rise in zip(row, slope, strict=True)]
        force, _, common, lever, _, lateral = self._values
        per = self._per_step
        u, v = (b / s, e / s) if s > 1e-12 else (0.0, 0.0)
        x, y, z = self._down
        d_common, d_lever = slope[2] * per, slope[3] * per
        pull = x * slope[4] * per + slope[5] * per * (b * y + e * z) - force
        self._force = (pull * u + lateral * y, pull * v + lateral * z)
        cables = []
        for p, q in self._directions:
            along = p * b + q * e
            radial = d_common + d_lever * along
            cables.append((common + lever * along, radial * u + lever * p, radial * v + lever * q))
        self._cables = cables
        across = force / s if s > 1e-9 else slope[0] * per
        rise = slope[0] * per - across
        self._stiff = (across + rise * u * u, rise * u * v, across + rise * v * v)

    def _move(self, wound: Sequence[float], damped: Sequence[float], stiffness: Sequence[float], dt: float) -> None:
        """Step of the curl: ``(M + dt C + dt^2 K) dv = dt (F - C v - dt K v)``.

        ``damped`` is wound + tau dwound/dt. The damping of a cable is in K, as k (1 + tau / dt).
        """
        mass, damping = self._curl.mass, self._values[1]
        (f, g), (k_yy, k_yz, k_zz), (v, w) = self._force, self._stiff, self._velocity
        more = 1.0 + self._damping_time / dt
        for i, (taken, p, q) in enumerate(self._cables):
            if wound[i] > taken:
                k = stiffness[i]
                tension = k * (damped[i] - taken)
                k *= more
                f, g = f + tension * p, g + tension * q
                k_yy, k_yz, k_zz = k_yy + k * p * p, k_yz + k * p * q, k_zz + k * q * q
        f -= damping * v + dt * (k_yy * v + k_yz * w)
        g -= damping * w + dt * (k_yz * v + k_zz * w)
        heavy = mass + dt * damping
        a, c, d = heavy + dt * dt * k_yy, dt * dt * k_yz, heavy + dt * dt * k_zz
        scale = dt / (a * d - c * c)
        v, w = v + scale * (d * f - c * g), w + scale * (a * g - c * f)
        b, e = self._curled[0] + dt * v, self._curled[1] + dt * w
        size = math.sqrt(b * b + e * e)
        if size > self._stroke:
            b, e = b * self._stroke / size, e * self._stroke / size
            outward = max(0.0, (v * b + w * e) / self._stroke**2)
            v, w = v - outward * b, w - outward * e
        self._curled, self._velocity = (b, e), (v, w)


def _interleave(curl: TrunkCurl) -> list[tuple[_Row, _Row]]:
    """Values of all tables at each point, and their rise to the next one."""
    points = list(zip(curl.force, curl.damping, curl.common, curl.lever, curl.axial, curl.lateral, strict=True))
    return [
        (here, tuple(b - a for a, b in zip(here, there, strict=True))) for here, there in itertools.pairwise(points)
    ]
