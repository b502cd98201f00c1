"""Possible distances of sections on the design's trunk: detects another trunk, another unit, or mixed-up names.

Two marked sections and the joints between them form a chain of straight links whose joint angles range from 0 to the
joint limit. The distance is largest for the straight chain. It is smallest for full curl to one side, as long as the
chain and its chord form a convex polygon (Schur's theorem: smaller angles, in space too, leave a chord that is not
shorter). A chain that curls further has no lower bound.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.session.sections import HeldShape
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset

SLACK_SHARE, SLACK = 0.10, 5e-3
"""Relative and absolute margin on the possible distances [-], [m] (ours)."""

LEAST_SHARE = 0.05
"""Largest distance over that of the straight trunk below which the unit must be wrong [-] (ours: the paper's trunk in
full curl has no ratio below 0.15)."""

SCALE = 0.01
"""Error of scale from which it is noted [-] (ours)."""


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
    """Refuse a recording whose distances between consecutive seen sections are impossible for the design.

    Raises:
        TakeError: where more than half of the distances are impossible, or all of them are nearly zero.
    """
    reach = {pair: compute_reach(design, *pair) for pair in {(i, j) for _, i, j, _ in _find_pairs(shapes)}}
    seen = [(i, j, apart, _widen(*reach[i, j])) for _, i, j, apart in _find_pairs(shapes)]
    wrong = [pair for pair in seen if not pair[3][0] <= pair[2] <= pair[3][1]]
    if max((apart / reach[i, j][1] for i, j, apart, _ in seen), default=1.0) < LEAST_SHARE:
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
        least, most = _expect(shapes[shape], design, i, j)
        over.append(apart / most)
        under.append(apart / least if least > 0 else np.inf)
    if not over:
        return []
    ratio = max(1.0, float(np.median(over))) * min(1.0, float(np.median(under)))
    if abs(ratio - 1) <= SCALE:
        return []
    what = f"sections are {abs(ratio - 1):.1%} {'further apart' if ratio > 1 else 'nearer together'} than the design's"
    return [f"{what}, in the median: check the calibration of the cameras, the trunk's size and where the markers sit"]


def _find_pairs(shapes: Sequence[HeldShape]) -> Iterator[tuple[int, int, int, float]]:
    """Shape, section, the next section that was seen, from 0, and their distance [m]."""
    for number, shape in enumerate(shapes):
        seen = np.flatnonzero(np.isfinite(shape.points).all(axis=1)).tolist()
        for i, j in pairwise(seen):
            yield number, i, j, float(np.linalg.norm(shape.points[j] - shape.points[i]))


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
