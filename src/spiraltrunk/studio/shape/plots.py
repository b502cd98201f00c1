"""Live plots of the tab: angles of the joints, and tensions of the cables across the gaps."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.drawing.axis_end import round_up
from spiraltrunk.studio.drawing.plot_lines import DASHES, label_axes
from spiraltrunk.studio.page.page import Page

if TYPE_CHECKING:
    from spiraltrunk.model.kinematics.shape import Shape

_HEIGHT = 136
"""Height of a plot [px]."""

_PAPER, _EQUILIBRIUM, _LIMIT = "#E69F00", "#7C8896", "#999999"
"""Colours of the lines: of the two models as in the scene."""


@final
class ShapePlots:
    """Two plots over the joints, base to tip."""

    def __init__(self, page: Page, design: TrunkDesign) -> None:
        """Add the plots where the page's container is open."""
        self._design = design
        self._joint = np.arange(1.0, design.n_joint + 1)
        none = np.zeros(design.n_joint)
        limit = np.full(design.n_joint, math.degrees(design.joint_limit))
        self._angle: Any = page.gui.add_uplot(
            (self._joint, none, none, limit), self._list_angles(has_paper=False), height=_HEIGHT,
            axes=label_axes("Joint, 1 at the base", "Angle [deg]"), legend={"show": False}, cursor=_CURSOR,
            scales={"x": self._across(), "y": {"range": (0.0, 1.1 * float(limit[0]))}}, padding=(8, 12, 0, 0),
        )  # fmt: skip
        self._most = 10.0
        self._tension: Any = page.gui.add_uplot(
            (self._joint, *(none for _ in range(design.n_cable))), self._list_tensions(), height=_HEIGHT,
            axes=label_axes("Gap at joint", "Tension [N]"), legend={"show": False}, cursor=_CURSOR,
            scales=self._scale_tension(), padding=(8, 12, 0, 0),
        )  # fmt: skip
        self._has_paper = False

    def draw(self, shape: Shape, paper: Shape | None) -> None:
        """Show an equilibrium, and the shape of the paper's model where there is one."""
        limit = np.full(self._design.n_joint, math.degrees(self._design.joint_limit))
        angle = np.degrees(shape.joint_angle)
        if (paper is not None) != self._has_paper:
            self._has_paper = paper is not None
            self._angle.series = self._list_angles(has_paper=self._has_paper)
        self._angle.data = (self._joint, np.degrees(paper.joint_angle) if paper else angle, angle, limit)
        if shape.forces is None:
            return
        tension = np.maximum(shape.forces.gap_tension, 0.0)
        most = round_up(1.02 * float(tension.max(initial=0.0)), 10.0)
        if most != self._most:
            self._most = most
            self._tension.scales = self._scale_tension()
        self._tension.data = (self._joint, *(np.ascontiguousarray(row) for row in tension.T))

    def remove(self) -> None:
        """Take the plots out of the panel."""
        self._angle.remove()
        self._tension.remove()

    def _list_angles(self, *, has_paper: bool) -> Any:
        dots = {"show": True, "size": 5}
        return (
            {"label": "joint"},
            {"label": "paper's model", "stroke": _PAPER, "width": 2, "points": dots, "show": has_paper},
            {"label": "equilibrium", "stroke": _EQUILIBRIUM, "width": 2, "points": dots},
            {"label": "limit", "stroke": _LIMIT, "width": 1, "dash": [6, 4], "points": {"show": False}},
        )

    def _list_tensions(self) -> Any:
        cables = (
            {
                "label": f"cable {i + 1}",
                "stroke": COLORS[i % len(COLORS)],
                "width": 2.5,
                "points": {"show": False},
                "dash": DASHES[i % len(DASHES)],
            }
            for i in range(self._design.n_cable)
        )
        return ({"label": "joint"}, *cables)

    def _across(self) -> Any:
        """Scale of the joints: one that followed the data would be lost when a plot is made anew."""
        return {"time": False, "range": (1.0, float(self._design.n_joint))}

    def _scale_tension(self) -> Any:
        return {"x": self._across(), "y": {"range": (0.0, self._most)}}


_CURSOR: Any = {"drag": {"x": False, "y": False, "setScale": False}}
