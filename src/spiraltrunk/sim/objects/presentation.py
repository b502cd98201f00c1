"""How an object stands on the ground: as its measures say, in a pose that was asked for, or as a strategy needs it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull

from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.geoms import Solid, compute_bounds
from spiraltrunk.sim.objects.profile import UPRIGHT
from spiraltrunk.sim.objects.spec import ObjectSpec
from spiraltrunk.sim.objects.stable_poses import HEIGHTS_EQUAL, build_pose, compute_stable_poses
from spiraltrunk.sim.objects.tessellation import hull_of_geom

POSES = ("upright", "lying")
"""Poses by name; a stable pose has its place in the list, from 0."""

STANDS = math.radians(5.0)
"""Least tilt at which an object falls over in the pose of its file for it to stay in it (ours) [rad]."""

UPRIGHT_COS = 0.985
"""Least cosine of the angle between an object's axis and the vertical in a pose that counts as upright (ours) [-]."""

TALL = 0.95
"""Least height of an upright pose over that of the tallest one (ours) [-]."""

UPRIGHT_SHARE = 0.75
"""Least height over the longest extent from which an object that rests as in its file stands upright, unless it is
lowest so (ours) [-]. A mug is not as tall as it is long with its handle."""

ROUND = ("cylinder", "cone", "ring", "bottle", "sphere")
"""Kinds of object that are surfaces of revolution about their axis."""

LYING_COS = 0.5
"""Largest cosine of the angle between an object's axis and the vertical in a pose that counts as lying (ours) [-]."""

LYING_SHARE = 0.05
"""Least probability of all poses together that count as lying, for an object to be laid in one (ours) [-]."""

LEVEL = 1e-3
"""Largest sine of the angle between an object's axis and the ground at which it counts as level (ours) [-]."""

SLIGHT = 1.5
"""Largest angle between a pose and that of the file at which nothing is told (ours) [deg]."""

SAME_SHARE = 0.02
"""Relative difference of the probabilities of poses that are equally probable (ours) [-]."""

_TURNED = "it would not stay as it is in the file"

_UP = np.array([1.0, 0.0, 0.0])
"""The direction of a standing object's frame that is up."""

_Z_TO_X = UPRIGHT.T
"""Rotation that turns z onto x."""


def present(shape: ObjectSpec, orientation: str) -> ObjectSpec:
    """The object with a frame that is right for a strategy's orientation on the ground.

    For "upright" its x axis points up as it stands; for "lying" its z axis does as it lies. A pose that was asked for
    stays: then only the frame changes, not how the object rests. Of a catalogue's object nothing changes.
    """
    if orientation == "upright":
        return _reframe(shape, _Z_TO_X, up="x") if shape.up == "z" else shape
    if shape.up == "x" and shape.pose:
        return _reframe(shape, _lay_frame(shape.solid, _UP), up="z")
    return shape


def find_longer_side(shape: ObjectSpec) -> tuple[float, float | None]:
    """Longer side of the least rectangle round an object that stands, its x axis up, seen from above.

    Returns:
        Its extent [m], and its angle from the world's x while the object's yaw is 0 [rad]; None for a round object.
    """
    return (max(shape.size[1:]), None) if shape.kind in ROUND else _find_longer_side(shape.solid)


@lru_cache(maxsize=64)
def _find_longer_side(solid: Solid) -> tuple[float, float]:
    ahead = _lay_frame(solid, _UP)[0]
    points = np.vstack([hull_of_geom(geom)[0] for geom in solid.geoms if geom.collides])
    x, y, _ = (UPRIGHT @ ahead).tolist()
    return float(np.ptp(points @ ahead)), math.atan2(y, x)


def natural_orientation(shape: ObjectSpec) -> str:
    """Orientation in which the object rests on the ground as its measures, its file or its pose say."""
    return "upright" if shape.up == "x" else "lying"


def as_measured(shape: ObjectSpec) -> ObjectSpec:
    """The object bound to the pose that its measures or its file say, whatever a strategy needs."""
    return shape if shape.pose else replace(shape, pose="measured")


def take_pose(shape: ObjectSpec, pose: str) -> ObjectSpec:
    """The object in a pose on the ground.

    Args:
        shape: the object.
        pose: "upright", its axis vertical; "lying", its axis horizontal, as it rests most probably, or in its most
            probable pose where it rarely rests so (`LYING_SHARE`); or the place of a stable pose, from 0, the most
            probable first (`compute_stable_poses`). The axis of a box is its longest extent. That of an object from a
            file is what ``axis=`` names; else the vertical, where its height there is at least `UPRIGHT_SHARE` of its
            longest extent and not its least one; else the longest extent.

    Raises:
        UnknownName: for another pose.
        DesignError: for a stable pose that it does not have.
    """
    shape = replace(shape, notes=tuple(note for note in shape.notes if not note.startswith(_TURNED)))
    if pose in POSES:
        along = _along_axis(shape)
        return replace(along, up="x", pose=pose) if pose == "upright" else replace(_lay(along), pose=pose)
    if not (pose.isascii() and pose.isdigit()):
        raise UnknownName("pose", pose, (*POSES, "0", "1", "..."))
    poses = compute_stable_poses(shape)
    if len(pose) > 3 or int(pose) >= len(poses):
        raise DesignError("object.pose", got=pose, allowed=f"upright, lying or 0 to {len(poses) - 1}, a stable pose")
    return replace(_stand_on(shape, poses[int(pose)].rotation[2]), pose=pose)


def settle(shape: ObjectSpec, up: np.ndarray) -> ObjectSpec:
    """An object from a file in the pose in which it rests: as in the file, else upright, else the most probable.

    The file's pose and the upright one count where the object stands in them by `STANDS`. Upright is the longest extent
    of the file, else, of an object that is askew in it, the tallest pose.

    Args:
        shape: the object, its axis along x.
        up: direction of its frame that the file says is up, shape (3,) [-].
    """
    poses = compute_stable_poses(shape)
    standing = [pose for pose in poses if pose.topple_angle >= STANDS]
    for wanted in (up, np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0])):
        for pose in standing:
            if float(pose.rotation[2] @ wanted) >= UPRIGHT_COS:
                stood, taken = _stand_near(shape, wanted, pose.rotation[2])
                return _note_turn(stood, taken, up)
    tallest = max(standing, key=lambda pose: pose.height, default=None)
    if tallest is not None and tallest.height >= TALL * max(pose.height for pose in poses):
        stood = _reframe(shape, _Z_TO_X @ _lay_frame(shape.solid, tallest.rotation[2]), up="x")
        return _note_turn(stood, tallest.rotation[2], up)
    if not poses:
        return shape
    likely = [pose for pose in poses if pose.probability > poses[0].probability * (1 - SAME_SHARE)]
    nearest = max(likely, key=lambda pose: float(pose.rotation[2] @ up))
    laid, filed = _stand_on(shape, nearest.rotation[2]), build_pose(shape.solid, up)
    is_level = abs(nearest.center_height / filed.center_height - 1) < HEIGHTS_EQUAL
    has_rolled = is_level and nearest.topple_angle == 0.0
    return laid if has_rolled else _note_turn(laid, nearest.rotation[2], up)


def _stand_near(shape: ObjectSpec, wanted: np.ndarray, stable: np.ndarray) -> tuple[ObjectSpec, np.ndarray]:
    """The object that rests with a direction up, or where it does not stand so with a stable one near; and which."""
    if build_pose(shape.solid, wanted).topple_angle >= STANDS:
        return _stand_on(shape, wanted), wanted
    if abs(float(stable[0])) < UPRIGHT_COS:
        return _stand_on(shape, stable), stable
    return _reframe(shape, _Z_TO_X @ _lay_frame(shape.solid, stable), up="x"), stable


def _note_turn(shape: ObjectSpec, taken: np.ndarray, up: np.ndarray) -> ObjectSpec:
    """The object with a note where another direction than that of its file, ``up``, was ``taken`` to be up."""
    angle = math.degrees(math.acos(float(np.clip(up @ taken, -1.0, 1.0))))
    if angle < SLIGHT:
        return shape
    told = f"{_TURNED}: it rests turned by {angle:.0f} deg; pose= says otherwise"
    return replace(shape, notes=(*shape.notes, told))


def _stand_on(shape: ObjectSpec, up: np.ndarray) -> ObjectSpec:
    """The object that rests with a direction of its frame up: its axis stays x where that is vertical or level."""
    if abs(float(up[0])) >= UPRIGHT_COS:
        flip = np.diag([-1.0, 1.0, -1.0]) if up[0] < 0 else np.eye(3)
        return _reframe(shape, flip, up="x")
    if abs(float(up[0])) < LEVEL:
        if shape.kind in ROUND:  # About its axis all directions are alike.
            return replace(shape, up="z")
        level = np.array([0.0, *(up[1:] / np.linalg.norm(up[1:]))])
        ahead = np.array([1.0, 0.0, 0.0])
        return _reframe(shape, np.stack([ahead, np.cross(level, ahead), level]), up="z")
    return _reframe(shape, _lay_frame(shape.solid, up), up="z")


def _lay(shape: ObjectSpec) -> ObjectSpec:
    """The object in its most probable pose with the axis level, or in its most probable one where those are rare."""
    poses = () if shape.kind in ROUND else compute_stable_poses(shape)
    if not poses:
        return replace(shape, up="z")
    level = [pose for pose in poses if abs(float(pose.rotation[2, 0])) < LYING_COS]
    if sum(pose.probability for pose in level) >= LYING_SHARE:
        return _stand_on(shape, level[0].rotation[2])
    return _reframe(shape, _lay_frame(shape.solid, poses[0].rotation[2]), up="z")


def _along_axis(shape: ObjectSpec) -> ObjectSpec:
    """A box or an object from a file with its axis along x (`take_pose`); another solid has its own axis."""
    is_file = shape.kind in {"mesh", "mjcf"}
    is_lowest = shape.size[2] <= min(shape.size) * (1 + SAME_SHARE)
    if is_file and shape.up == "z" and shape.size[2] >= UPRIGHT_SHARE * max(shape.size) and not is_lowest:
        return _reframe(shape, _Z_TO_X, up="x")
    stands = is_file and shape.up == "x"
    if stands or not (is_file or shape.kind == "box") or shape.size[0] >= max(shape.size) * (1 - 1e-9):
        return shape
    turn = np.roll(np.eye(3), -int(np.argmax(shape.size)), axis=0)
    return _reframe(shape, turn, up=shape.up)


def _lay_frame(solid: Solid, up: np.ndarray) -> np.ndarray:
    """Rotation to a frame with z along ``up`` and x along the longer side of the least rectangle round the object."""
    up = up / np.linalg.norm(up)
    side = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = side - (side @ up) * up
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    points = np.vstack([hull_of_geom(geom)[0] for geom in solid.geoms if geom.collides])
    flat = points @ np.stack([first, second], axis=1)
    corners = flat[ConvexHull(flat).vertices]
    angles = [math.atan2(*(end - start)[::-1]) % (math.pi / 2) for start, end in pairwise([*corners, corners[0]])]
    best = min((0.0, *angles), key=lambda angle: round(_area(corners, angle), 9))
    if _spans(corners, best)[1] > _spans(corners, best)[0] * (1 + 1e-9):
        best += math.pi / 2
    ahead = math.cos(best) * first + math.sin(best) * second
    return np.stack([ahead, np.cross(up, ahead), up])


def _spans(corners: np.ndarray, angle: float) -> np.ndarray:
    """Extents along and across a direction, shape (2,) [m]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(np.ptp(corners @ np.array([[c, -s], [s, c]]), axis=0))


def _area(corners: np.ndarray, angle: float) -> float:
    return float(np.prod(_spans(corners, angle)))


def _reframe(shape: ObjectSpec, turn: np.ndarray, *, up: str) -> ObjectSpec:
    """The object in a frame that is turned, its origin in the middle of its extents."""
    if np.allclose(turn, np.eye(3), atol=1e-12):
        return replace(shape, up=up)
    if shape.kind == "sphere":
        return replace(shape, up=up)
    is_permuted = bool((np.abs(np.abs(turn) - np.round(np.abs(turn))) < 1e-12).all())
    if shape.kind == "box" and is_permuted:
        x, y, z = (float(extent) for extent in np.abs(np.round(turn)) @ np.array(shape.size))
        return replace(shape, size=(x, y, z), up=up)
    turned = shape.solid.transformed(rotation=turn)
    low, high = compute_bounds(turned.geoms)
    loaded = turned.transformed(offset=-(low + high) / 2)
    kind = shape.kind if shape.kind in {"mesh", "mjcf"} else "solid"
    before = shape.turned if shape.kind == kind else shape.kind
    return replace(shape, kind=kind, size=loaded.extents(), neck=0.0, loaded=loaded, up=up, turned=before)
