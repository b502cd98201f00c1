"""Geometry of what projects to one side of an object that stands, such as the handle of a mug."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Handle:
    """What projects to one side of the object's body, seen from above."""

    direction: np.ndarray
    """Horizontal unit vector from the middle of the body to the handle, shape (3,) [-]."""
    body_width: float
    """Diameter of the least circle round the body [m]."""
    body_offset: np.ndarray
    """Horizontal displacement from the object's centre to the middle of that circle, shape (3,) [m]."""
