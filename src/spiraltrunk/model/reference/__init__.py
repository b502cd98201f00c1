"""The forward model of "Grasping by Spiraling": rest under gravity, bending by Algorithm 1, twisting by Algorithm 2."""

from spiraltrunk.model.reference.forward import (
    PlaneShape,
    bend_dorsal,
    bend_dorsal_points,
    bend_ventral,
    first_shut,
    rest,
    twist,
)

__all__ = ["PlaneShape", "bend_dorsal", "bend_dorsal_points", "bend_ventral", "first_shut", "rest", "twist"]
