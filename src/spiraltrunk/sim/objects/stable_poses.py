"""Poses in which an object rests on a plane, and how probable they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, final

import numpy as np
from scipy.spatial import ConvexHull

from spiraltrunk.control.object_profile import StablePose
from spiraltrunk.sim.objects.geoms import Solid
from spiraltrunk.sim.objects.profile import compute_stability, foot_directions
from spiraltrunk.sim.objects.spec import ObjectSpec
from spiraltrunk.sim.objects.tessellation import hull_of_geom

if TYPE_CHECKING:
    from trimesh import Trimesh

CORNERS = 32
"""Corners of a polygon that represents a circle in the search for poses (ours)."""

FACES_MOST = 1200
"""Triangles to which a finer hull is thinned out for the search (ours)."""

LINK = np.cos(np.radians(15.0))
"""Cosine of the largest angle between neighbouring poses that are one: a rolling object's (ours) [-]."""

ROLLS = np.cos(np.radians(30.0))
"""Cosine of the least angle through which linked poses spread where the object rolls (ours) [-]."""

HEIGHTS_EQUAL = 0.02
"""Largest relative difference in height of the centre of mass between poses that are one (ours) [-]."""

SAME = np.cos(np.radians(5.0))
"""Cosine of the largest angle between poses that count as the same (ours) [-]."""

PROBABILITY_LEAST = 0.005
"""Least probability of a pose that is listed (ours) [-]."""


def compute_stable_poses(shape: ObjectSpec) -> tuple[StablePose, ...]:
    """Stable poses of the object's convex hull with its own centre of mass, the most probable first.

    The probabilities are quasi-static (trimesh.poses, after Goldberg et al., 1999). Poses between which the object
    rolls are one pose. Where the centre of mass lies outside the hull, there is none.
    """
    return tuple(group.pose for group in _compute(shape.solid))


def find_rolls(shape: ObjectSpec, up: np.ndarray) -> bool:
    """Whether the object rolls where it rests with a direction of its frame up, shape (3,) [-].

    It does where the stable pose with the nearest direction up, of all that are linked to one, is a rolling one.
    """
    groups = _compute(shape.solid)
    nearness = [float((group.ups @ up).max()) for group in groups]
    i = int(np.argmax(nearness)) if groups else -1
    return i >= 0 and nearness[i] > SAME and groups[i].pose.topple_angle == 0.0


@final
@dataclass(frozen=True, eq=False)
class _Group:
    """Poses that are one."""

    pose: StablePose
    """The most probable of them, with the probability of all."""
    ups: np.ndarray
    """Directions of the object's frame that are up in each, shape (n, 3) [-]."""


@lru_cache(maxsize=64)
def _compute(solid: Solid) -> tuple[_Group, ...]:
    from trimesh.poses import compute_stable_poses as search

    hull = _hull(solid)
    away = np.einsum("ij,ij->i", solid.centroid - hull.triangles_center, hull.face_normals)
    if not (away < -1e-9).all():
        return ()
    with np.errstate(invalid="ignore"):  # Rounding makes a cosine exceed 1.
        transforms, probabilities = search(hull, center_mass=solid.centroid, seed=0)
    ups = transforms[:, 2, :3]
    lows = np.array([float((hull.vertices @ up).min()) for up in ups])
    heights = ups @ solid.centroid - lows
    poses = []
    for group in _link(ups, heights):
        chance = float(probabilities[group].sum())
        if chance >= PROBABILITY_LEAST:
            best = group[np.argmax(probabilities[group])]
            pose = build_pose(solid, ups[best], chance)
            rolls = float((ups[group] @ ups[best]).min()) < ROLLS
            poses.append(_Group(replace(pose, topple_angle=0.0) if rolls else pose, ups[group]))
    return tuple(sorted(_unite_rolling(poses), key=lambda group: -group.pose.probability))


def _unite_rolling(groups: list[_Group]) -> list[_Group]:
    """One pose of all those of equal height in which the object rolls, such as a ball's."""
    united: list[_Group] = []
    for group in sorted(groups, key=lambda group: -group.pose.probability):
        pose = group.pose
        for i, same in enumerate(united):
            other = same.pose
            equal = abs(pose.center_height / other.center_height - 1) <= HEIGHTS_EQUAL
            if equal and pose.topple_angle == other.topple_angle == 0.0:
                more = replace(other, probability=other.probability + pose.probability)
                united[i] = _Group(more, np.vstack([same.ups, group.ups]))
                break
        else:
            united.append(group)
    return united


def build_pose(solid: Solid, up: np.ndarray, probability: float = 0.0) -> StablePose:
    """The pose in which an object rests with a direction of its frame up, shape (3,) [-], whether it stays so or not.

    Its angle of falling over is 0 where it would not stay.
    """
    turn = rotate_up(up)
    reach = [geom.reach(turn[2]) for geom in solid.geoms if geom.collides]
    depth = [geom.reach(-turn[2]) for geom in solid.geoms if geom.collides]
    topple, _ = compute_stability(solid, turn, foot_directions(solid, turn))
    return StablePose(
        rotation=turn, probability=probability, height=float(max(reach) + max(depth)),
        center_height=float(turn[2] @ solid.centroid + max(depth)), topple_angle=topple,
    )  # fmt: skip


def rotate_up(up: np.ndarray) -> np.ndarray:
    """Rotation of the object's frame into the world that turns a direction of the frame up, shape (3, 3) [-].

    The frame's x axis, or where that is up its y axis, points along the world's x as far as it can.
    """
    up = up / np.linalg.norm(up)
    ahead = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.99 else np.array([0.0, 1.0, 0.0])
    ahead = ahead - (ahead @ up) * up
    ahead /= np.linalg.norm(ahead)
    return np.stack([ahead, np.cross(up, ahead), up])


def _link(ups: np.ndarray, heights: np.ndarray) -> list[np.ndarray]:
    """Poses that are linked by neighbours, as groups of their places."""
    from scipy.sparse.csgraph import connected_components

    near = (ups @ ups.T >= LINK) & (np.abs(heights[:, None] / heights - 1) <= HEIGHTS_EQUAL)
    count, label = connected_components(near, directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]


def _hull(solid: Solid) -> Trimesh:
    points = np.vstack([hull_of_geom(geom, CORNERS)[0] for geom in solid.geoms if geom.collides])
    hull = _mesh_of(points)
    if len(hull.faces) > FACES_MOST:
        from fast_simplification import simplify

        thin, _ = simplify(hull.vertices.astype(np.float32), hull.faces, target_count=FACES_MOST // 2)
        hull = _mesh_of(np.asarray(thin, float))
    return hull


def _mesh_of(points: np.ndarray) -> Trimesh:
    import trimesh

    mesh = trimesh.Trimesh(points, ConvexHull(points).simplices, process=False)
    mesh.remove_unreferenced_vertices()
    trimesh_repair: Any = trimesh.repair  # Untyped.
    trimesh_repair.fix_normals(mesh)
    return mesh
