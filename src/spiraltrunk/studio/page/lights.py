"""Light of the scene."""

from __future__ import annotations

from viser import SceneApi

SKY, GROUND = (255, 255, 255), (80, 84, 94)
"""Colours of surfaces that face the light, and of those that face away from it."""

_STRENGTH = 3.3
"""Its strength, in three.js's unit [-]: colours are shown about as they are given."""

_PLACE = (-0.6, -2.0, 2.8)
"""Where it comes from: the upper left of a person who looks along y."""


def light_scene(scene: SceneApi) -> None:
    """Put one soft light in the place of viser's lamps, their shadows, and its map of surroundings.

    The brightness of a surface depends on its direction alone. Where a browser draws without a GPU, shadows and the map
    take four fifths of the time of a picture.
    """
    scene.configure_environment_map(None)
    scene.configure_default_lights(enabled=False)
    scene.add_light_hemisphere("/light", sky_color=SKY, ground_color=GROUND, intensity=_STRENGTH, position=_PLACE)
