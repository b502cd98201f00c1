"""Geometry of a wound drum: cable pulled in against angle, layer by layer."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import final

from spiraltrunk.design.drum import PITCH, SPARE, DrumDesign
from spiraltrunk.errors import DesignError, Unquoted

_MOST_LAYERS = 100
"""Most layers of cable on a drum (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class DrumGeometry:
    """Drum that winds layer upon layer; angle and pull are 0 at the straight trunk and grow as the cable is wound in.

    Layer j = 0, 1, ... holds ``turns_per_layer`` turns of radius r_j = r_0 + j d, where d is the cable's diameter (a
    cable that lies in the grooves of the layer below rises by 0.87 d instead). The length on the drum is continuous and
    linear in the angle within a layer; the pitch of the helix lengthens a turn by less than 1e-4 and is left out. One
    layer is the case of the drums that CAD makes.
    """

    design: DrumDesign
    """Radius, width, cable and travel."""

    def __post_init__(self) -> None:
        if len(self._layers[0]) > _MOST_LAYERS:
            got = Unquoted(f"{1e3 * self.design.width:g} mm, {len(self._layers[0])} layers of cable")
            raise DesignError("drum.width", got=got, allowed=f"a drum that needs at most {_MOST_LAYERS} layers")

    @cached_property
    def turns_per_layer(self) -> int:
        """Whole turns side by side, at least one [-]."""
        return max(1, math.floor(self.design.width / (PITCH * self.design.cable_diameter) + 1e-9))

    @property
    def n_layer(self) -> int:
        """Layers of cable when the travel with `SPARE` is wound in [-]."""
        return len(self._layers[0])

    @property
    def radius_max(self) -> float:
        """Radius of the outermost layer [m]."""
        return self._layers[2][-1]

    def radius(self, angle: float) -> float:
        """Radius of the layer that is wound at an angle [rad] from the straight trunk [m]."""
        starts, _, radii = self._layers
        return radii[0] if len(radii) == 1 else radii[_layer_of(starts, angle)]

    def pull(self, angle: float) -> float:
        """Cable pulled in since the straight trunk at an angle [rad] from there [m]."""
        starts, pulls, radii = self._layers
        layer = _layer_of(starts, angle)
        return pulls[layer] + radii[layer] * (angle - starts[layer])

    def angle(self, pull: float) -> float:
        """Angle from the straight trunk [rad] at which so much cable [m] is pulled in: the inverse of `pull`."""
        starts, pulls, radii = self._layers
        layer = _layer_of(pulls, pull)
        return starts[layer] + (pull - pulls[layer]) / radii[layer]

    @cached_property
    def _layers(self) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
        """Angle [rad] and pull [m] at the start of each layer, and its radius [m].

        The innermost layer continues below its start and the outermost beyond its end: both maps are one to one.
        """
        design, turn = self.design, 2 * math.pi * self.turns_per_layer
        starts, lengths, radii = [0.0], [0.0], [design.winding_radius]
        dead = 2 * math.pi * design.dead_turns

        def length_at(angle: float) -> float:
            layer = _layer_of(starts, angle)
            return lengths[layer] + radii[layer] * (angle - starts[layer])

        def is_full(length: float) -> bool:
            return starts[-1] + turn > dead and length <= lengths[-1] + radii[-1] * turn + 1e-12

        while len(radii) <= _MOST_LAYERS:
            spare = (1 + SPARE) * (design.travel_in + design.travel_out)
            if is_full(length_at(dead) + spare):
                break
            lengths.append(lengths[-1] + radii[-1] * turn)
            starts.append(starts[-1] + turn)
            radii.append(radii[-1] + design.cable_diameter)
        straight = length_at(dead) + design.travel_out
        layer = _layer_of(lengths, straight)
        zero = starts[layer] + (straight - lengths[layer]) / radii[layer]
        return tuple(s - zero for s in starts), tuple(length - straight for length in lengths), tuple(radii)


def _layer_of(starts: tuple[float, ...] | list[float], value: float) -> int:
    return max(bisect_right(starts, value) - 1, 0)
