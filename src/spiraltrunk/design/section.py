"""One section: a quadrilateral between backbone and outer contour, revolved about the straight backbone edge.

In the section's own frame x runs along the axis from the proximal joint. The solid fills, at distance rho from the
axis, x from rho tan(lean_proximal) to length - rho tan(lean_distal). Volume and moments are exact integrals of that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DesignError


@final
@dataclass(frozen=True, kw_only=True)
class SectionSolid:
    """Revolved quadrilateral with two conical faces."""

    length: float
    """Distance between the two joint centres along the axis [m]."""
    radius: float
    """Radius of the outer surface, which is parallel to the axis [m]."""
    lean_proximal: float
    """Angle of the proximal face from the axis' normal, positive into the section [rad]."""
    lean_distal: float
    """Angle of the distal face from the axis' normal, positive into the section [rad]."""

    def __post_init__(self) -> None:
        check_number("section.length", self.length, above=0.0)
        check_number("section.radius", self.radius, above=0.0)
        for name in ("lean_proximal", "lean_distal"):
            check_number(f"section.{name}", getattr(self, name), above=-math.pi / 2, below=math.pi / 2)
        if self.rim_start >= self.rim_end:
            slopes = self._t1 + self._t2  # Zero where the faces are parallel and the length is lost in rounding.
            widest = f" (radius below {self.length / slopes:g} m)" if slopes else ""
            raise DesignError("section.radius", got=self.radius, allowed=f"an outer surface of positive length{widest}")

    @property
    def _t1(self) -> float:
        return math.tan(self.lean_proximal)

    @property
    def _t2(self) -> float:
        return math.tan(self.lean_distal)

    @property
    def rim_start(self) -> float:
        """Axial position of the proximal face's outer corner [m]."""
        return self.radius * self._t1

    @property
    def rim_end(self) -> float:
        """Axial position of the distal face's outer corner [m]."""
        return self.length - self.radius * self._t2

    @cached_property
    def volume(self) -> float:
        """Volume 2 pi (L R^2 / 2 - (t1 + t2) R^3 / 3) [m^3]."""
        return 2 * math.pi * (self.length * self.radius**2 / 2 - (self._t1 + self._t2) * self.radius**3 / 3)

    @cached_property
    def centroid(self) -> float:
        """Axial position of the centroid of the uniform solid [m]."""
        length, r = self.length, self.radius
        moment = length**2 * r**2 / 2 - 2 * length * self._t2 * r**3 / 3 + (self._t2**2 - self._t1**2) * r**4 / 4
        return math.pi * moment / self.volume

    @cached_property
    def gyration_axial(self) -> float:
        """Moment of inertia about the axis, per mass [m^2]."""
        r = self.radius
        return 2 * math.pi * (self.length * r**4 / 4 - (self._t1 + self._t2) * r**5 / 5) / self.volume

    @cached_property
    def gyration_transverse(self) -> float:
        """Moment of inertia about a cross axis through the centroid, per mass [m^2]."""
        length, r, t1, t2 = self.length, self.radius, self._t1, self._t2
        distal = length**3 * r**2 / 2 - length**2 * t2 * r**3 + 3 * length * t2**2 * r**4 / 4 - t2**3 * r**5 / 5
        about_joint = 2 * math.pi * (distal - t1**3 * r**5 / 5) / 3 / self.volume
        return self.gyration_axial / 2 + about_joint - self.centroid**2
