"""What an object is: extents, volume, stability, sections by height and stable poses, as it rests on the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.object_profile import ObjectProfile
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.objects.geoms import HIDDEN, Geom, Solid, geom_volume
from spiraltrunk.sim.objects.presentation import as_measured, present
from spiraltrunk.sim.objects.profile import compute_profile
from spiraltrunk.sim.objects.spec import ObjectSpec
from spiraltrunk.sim.objects.stable_poses import HEIGHTS_EQUAL, SAME, compute_stable_poses, find_rolls
from spiraltrunk.sim.objects.tessellation import hull_faces, hull_of_geom


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Description:
    """An object as it rests on the ground, in a frame with z up and the origin in the middle of its extents."""

    shape: ObjectSpec
    """The object, its frame's z up."""
    volume: float
    """Volume of the object, without hollows that are filled for contact [m^3]."""
    profile: ObjectProfile
    """Sections by height, with the stable poses; their rotations are from the pose in which it rests."""
    triangles: np.ndarray
    """Surface that is drawn, counter-clockwise from outside, shape (n, 3, 3) [m]."""

    @property
    def pose(self) -> int | None:
        """Place of the stable pose in which it rests; None where it would not stay so."""
        poses, center = self.profile.stable_poses, self.profile.center_height
        for i, pose in enumerate(poses):
            leans = self.profile.topple_angle == 0.0 < pose.topple_angle
            rolls = pose.topple_angle == self.profile.topple_angle == 0.0
            is_level = rolls and abs(pose.center_height / center - 1) < HEIGHTS_EQUAL
            if (pose.rotation[2, 2] > SAME and not leans) or is_level:
                return i
        return None

    @property
    def center(self) -> np.ndarray:
        """Centre of mass: horizontally from the middle of the extents, and its height, shape (3,) [m]."""
        x, y, _ = self.shape.center()
        return np.array([x, y, self.profile.center_height])


def describe_object(shape: ObjectSpec) -> Description:
    """Everything that follows from an object's shape and mass."""
    resting = present(as_measured(shape), "lying")
    profile = replace(compute_profile(resting, "lying"), stable_poses=compute_stable_poses(resting))
    if find_rolls(resting, np.array([0.0, 0.0, 1.0])):  # Over its edges, where it is of many faces.
        profile = replace(profile, topple_angle=0.0, support_radius=0.0)
    return Description(
        shape=resting, volume=compute_volume(shape), profile=profile,
        triangles=build_triangles(resting.solid),
    )  # fmt: skip


def compute_volume(shape: ObjectSpec) -> float:
    """Volume of an object [m^3]; of an MJCF body the sum over its geoms, which may overlap.

    Of an MJCF body the geoms count that collide and are drawn. Where none is both, as where one mesh is drawn and its
    convex parts collide, those count that are drawn, and where none is drawn those that collide.
    """
    solid = shape.solid
    if solid.volume is not None:
        return solid.volume
    drawn = _list_drawn(solid)
    return sum(geom_volume(geom) for geom in tuple(geom for geom in drawn if geom.collides) or drawn)


def build_triangles(solid: Solid) -> np.ndarray:
    """Triangles of all drawn geoms, counter-clockwise from outside, shape (n, 3, 3) [m]."""
    return np.vstack([_geom_triangles(geom) for geom in _list_drawn(solid)])


def _list_drawn(solid: Solid) -> tuple[Geom, ...]:
    """Geoms that are drawn; all of a solid whose geoms are all hidden, as in an MJCF file with group 3 alone."""
    return tuple(geom for geom in solid.geoms if geom.group < HIDDEN) or solid.geoms


def _geom_triangles(geom: Geom) -> np.ndarray:
    if geom.vertices is not None and geom.faces is not None:
        return (geom.vertices @ geom.rotation.T + geom.position)[geom.faces]
    points, _ = hull_of_geom(geom, 48)
    return np.asarray(points[hull_faces(points)])


def list_figures(about: Description, name: str) -> dict[str, Any]:
    """Figures of an object by the keys of ``spiraltrunk object --json``."""
    profile, shape = about.profile, about.shape
    poses = [
        {
            "probability": pose.probability, "height_m": pose.height, "center_height_m": pose.center_height,
            "topple_deg": math.degrees(pose.topple_angle), "rotation_wxyz": pose.rotation_wxyz,
        }
        for pose in profile.stable_poses
    ]  # fmt: skip
    return {
        "object": name,
        "kind": shape.kind,
        "pose": about.pose,
        "extents_m": np.array(shape.size),
        "mass_kg": shape.mass,
        "volume_m3": about.volume,
        "density_kg_m3": shape.mass / about.volume,
        "center_of_mass_m": about.center,
        "topple_deg": math.degrees(profile.topple_angle),
        "support_radius_m": profile.support_radius,
        "grip_width_m": profile.grip_width,
        "grip_height_m": profile.grip_height,
        "hull_excess": shape.solid.excess,
        "stable_poses": poses,
        "profile": {
            "height_m": profile.height, "girth_m": profile.girth, "width_least_m": profile.width_least,
            "width_most_m": profile.width_most,
        },
        "warnings": list(shape.warnings),
    }  # fmt: skip
