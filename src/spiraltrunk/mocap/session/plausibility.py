"""Checks of a recording against design and run: detect another trunk, unit, axis convention or run, or mixed-up names.

Two marked sections and the joints between them form a chain of straight links whose joint angles range from 0 to the
joint limit. The distance is largest for the straight chain. It is smallest for full curl to one side, as long as the
chain and its chord form a convex polygon (Schur's theorem: smaller angles, in space too, leave a chord that is not
shorter). A chain that curls further has no lower bound.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Run
from spiraltrunk.mocap.session.sections import HeldShape
from spiraltrunk.mocap.signal.registration import mean_rotation
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset

SLACK_SHARE, SLACK = 0.10, 5e-3
"""Relative and absolute margin on the possible distances [-], [m] (ours)."""

LEAST_SHARE = 0.05
"""Largest distance over that of the straight trunk below which the unit must be wrong [-] (ours: the paper's trunk in
full curl has no ratio below 0.15)."""

SCALE = 0.01
"""Error of scale from which it is noted [-] (ours)."""

_NOTED, _REFUSED = math.radians(2.0), math.radians(10.0)
"""Differences between set and recorded tilt of the base from which it is noted, and refused [rad] (ours)."""


def compute_reach(design: TrunkDesign, one: int, other: int) -> tuple[float, float]:
    """Least and largest distance of the marked points of two sections, counted from 0, ``one`` below ``other`` [m].

    For neighbours with links a and b and the limit q they are sqrt(a^2 + b^2 + 2 a b cos q) and a + b.
    """
    offset, length = compute_marker_offset(design), design.section_length
    pieces = np.array([length[one] - offset[one], *length[one + 1 : other], offset[other]])
    turns = np.broadcast_to(design.joint_limit, (design.n_section - 1,))[one:other]
    angle = np.concatenate([[0.0], np.cumsum(turns)])
    edges = pieces[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    chord = edges.sum(axis=0)
    closed = np.vstack([edges, -chord])
    after = np.roll(closed, -1, axis=0)
    outer = np.arctan2(closed[:, 0] * after[:, 1] - closed[:, 1] * after[:, 0], (closed * after).sum(axis=1))
    is_convex = bool((outer >= -1e-9).all() and outer.sum() < 3 * np.pi)
    return (float(np.linalg.norm(chord)) if is_convex else 0.0), float(pieces.sum())


def check_trunk(shapes: Sequence[HeldShape], design: TrunkDesign, source: str) -> None:
    """Refuse distances of seen neighbours of which half are impossible for the design, or all nearly zero."""
    reach = {pair: compute_reach(design, *pair) for pair in {(i, j) for _, i, j, _ in _find_pairs(shapes)}}
    seen = [(i, j, apart, _widen(*reach[i, j])) for _, i, j, apart in _find_pairs(shapes)]
    wrong = [pair for pair in seen if not pair[3][0] <= pair[2] <= pair[3][1]]
    if all(apart < LEAST_SHARE * reach[i, j][1] for i, j, apart, _ in seen):
        wrong = seen
    if 2 * len(wrong) > len(seen):
        i, j, apart, (least, most) = wrong[0]
        raise TakeError(
            f"sections {i + 1} and {j + 1} are {1e3 * apart:.4g} mm apart; allowed: "
            f"{1e3 * max(least, LEAST_SHARE * reach[i, j][1]):.1f} to {1e3 * most:.1f} mm, the range of the "
            f"design {design.name!r} and {SLACK_SHARE:.0%} + {1e3 * SLACK:g} mm: is it another trunk, another "
            "unit, or are sections named wrongly?", file=source,
        )  # fmt: skip


def check_scale(shapes: Sequence[HeldShape], design: TrunkDesign) -> list[str]:
    """A note where the median distance of sections is larger or smaller than the design's by `SCALE`.

    The axes of two neighbours determine the bend q between them, and so their distance. Where axes are unknown, the
    excess over the straight trunk and the deficit under full curl count.
    """
    over, under = [], []
    for shape, i, j, apart in _find_pairs(shapes):
        least, most = _expect(shape, design, i, j)
        over.append(apart / most)
        under.append(apart / least if least > 0 else np.inf)
    if not over:
        return []
    ratio = max(1.0, float(np.median(over))) * min(1.0, float(np.median(under)))
    if abs(ratio - 1) <= SCALE:
        return []
    what = f"sections are {abs(ratio - 1):.1%} {'further apart' if ratio > 1 else 'nearer together'} than the design's"
    return [f"{what}, in the median: check the calibration of the cameras, the trunk's size and where the markers sit"]


def _find_pairs(shapes: Sequence[HeldShape]) -> Iterator[tuple[HeldShape, int, int, float]]:
    """Shape, section, the next section that was seen, from 0, and their distance [m]."""
    for shape in shapes:
        seen = np.flatnonzero(np.isfinite(shape.points).all(axis=1)).tolist()
        for i, j in pairwise(seen):
            yield shape, i, j, float(np.linalg.norm(shape.points[j] - shape.points[i]))


def _widen(least: float, most: float) -> tuple[float, float]:
    return least * (1 - SLACK_SHARE) - SLACK, most * (1 + SLACK_SHARE) + SLACK


def _expect(shape: HeldShape, design: TrunkDesign, i: int, j: int) -> tuple[float, float]:
    """Least and largest distance by the design, equal where the bend between neighbours is known [m]."""
    cosine = float(shape.rotation[i, :, 0] @ shape.rotation[j, :, 0])
    if j > i + 1 or not np.isfinite(cosine):
        return compute_reach(design, i, j)
    offset = compute_marker_offset(design)
    before, beyond = float(design.section_length[i] - offset[i]), float(offset[j])
    apart = float(np.sqrt(before**2 + beyond**2 + 2 * before * beyond * cosine))
    return apart, apart


def check_base(held: Sequence[HeldShape], run: Run, source: str) -> list[str]:
    """A note where the base is seen to have another tilt than the run; a large difference is refused."""
    rotation = mean_rotation(np.array([shape.base_rotation for shape in held]))
    if not np.isfinite(rotation).all():
        return []
    seen = math.asin(float(np.clip(-rotation[1, 0], -1.0, 1.0)))
    expected = math.asin(math.sin(run.theta_0))
    angles = f"{math.degrees(seen):z.1f} deg below the horizontal, not {math.degrees(expected):z.1f}"
    reason = f"the base is tilted otherwise than set: its axis is {angles}"
    if abs(seen - expected) > _REFUSED:
        tilt = f"tilt_deg = {90 - math.degrees(run.theta_0):g}"
        advice = (
            f"check --axes, whether the recording is of run {run.name!r}, its {tilt} in the protocol, and that the "
            "body's x lies along the base axis (--rotations ignore does without it)"
        )
        raise TakeError(f"{reason}; allowed: at most {math.degrees(_REFUSED):g} deg off; {advice}", file=source)
    return [reason] if abs(seen - expected) > _NOTED else []


def check_order(shapes: list[HeldShape], source: str) -> None:
    """Refuse markers that are numbered in the wrong direction: their axes point towards the base."""
    for number in range(shapes[0].points.shape[0] - 1):
        steps = [shape.rotation[number, :, 0] @ (shape.points[number + 1] - shape.points[number]) for shape in shapes]
        known = np.array(steps)[np.isfinite(steps)]
        if len(known) and np.mean(known < 0) > 0.5:
            raise TakeError(
                f"the axis of section {number + 1} points towards the base; allowed: markers 1 to 3 counted from the "
                "dorsal one (y) towards z, as cables 1 to 3 are, sections numbered from the base, and --axes that say "
                "whether the export is left-handed (mirrored); orientation = \"none\" does without the sections' axes",
                file=source,
            )  # fmt: skip
