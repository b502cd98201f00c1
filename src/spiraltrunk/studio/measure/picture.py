"""Picture of the tab: the modelled trunk in the colours of its error, and the measured points."""

from __future__ import annotations

from typing import Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.studio.drawing.base_plate import add_base, turn_base
from spiraltrunk.studio.drawing.note import add_note
from spiraltrunk.studio.drawing.trunk_view import HANGING, UPRIGHT, Poses, TrunkView, linear_color
from spiraltrunk.studio.measure.error_scale import color_distances
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.validate.overlay import RunOverlay

MEASURED = (213, 94, 0)
"""Colour of measured points: vermilion of Okabe and Ito."""


@final
class MeasurePicture:
    """Nodes of the tab below ``/measure``."""

    def __init__(self, page: Page, design: TrunkDesign) -> None:
        self._page, self._design = page, design
        count = design.n_section
        self._root = page.scene.add_frame("/measure/all", show_axes=False)
        self._model = TrunkView(page, "/measure/all/model", design, opacity=0.75, is_data=True)
        self._measured = page.scene.add_frame("/measure/all/measured", show_axes=False, wxyz=UPRIGHT, visible=False)
        page.scene.add_frame("/measure/all/world", show_axes=False, wxyz=UPRIGHT)
        self._base = add_base(page, "/measure/all/world/base", design)
        self._note: Any = add_note(page, "/measure/all/world/note", design, "the design; no recording yet")
        self._balls: Any = None
        self._line: Any = page.scene.add_line_segments(
            "/measure/all/measured/line", np.zeros((count - 1, 2, 3)), MEASURED, thickness=3.0,
            thickness_units="screen",
        )  # fmt: skip
        self._away: Any = page.scene.add_line_segments(
            "/measure/all/measured/away", np.zeros((count, 2, 3)), MEASURED, thickness=1.5,
            thickness_units="screen",
        )  # fmt: skip
        self.draw_straight()

    def draw(self, run: RunOverlay, take: int, moment: int, most: float) -> None:
        """Draw one moment of a take; the scale of colours ends at ``most`` [m]."""
        one = run.takes[take]
        shape, measured = int(one.shape[moment]), one.points[moment]
        axes, points = run.rotation[shape], run.predicted[shape]
        origin = points - compute_marker_offset(self._design)[:, None] * axes[..., 0]
        colors = color_distances(np.linalg.norm(measured - points, axis=-1), most)
        self._model.draw(Poses(position=origin, rotation=axes), colors, colors)
        is_seen = np.isfinite(measured).all(axis=-1)
        place = np.where(is_seen[:, None], measured, points)
        if self._balls is None:
            self._balls = self._add_balls()
        self._balls.batched_positions = place
        self._balls.batched_scales = np.where(is_seen, np.maximum(0.3 * self._design.section_radius, 2e-3), 1e-6)
        seen = measured[is_seen]
        self._line.points = np.stack([seen[:-1], seen[1:]], axis=1)
        self._away.points = np.stack([place, points], axis=1)
        turn_base(self._base, run.theta_0)
        self._measured.visible, self._note.visible = True, False

    def _add_balls(self) -> Any:
        """Measured points; the package of the ball is imported here, in use."""
        import trimesh

        ball = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
        count = self._design.n_section
        wxyz = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        return self._page.scene.add_batched_meshes_simple(
            "/measure/all/measured/points", np.array(ball.vertices), np.array(ball.faces), wxyz, np.zeros((count, 3)),
            batched_scales=np.full(count, 1e-6), batched_colors=linear_color(MEASURED), lod="off",
        )  # fmt: skip

    def draw_straight(self) -> None:
        """Draw the straight trunk alone, where nothing is compared."""
        self._model.draw_straight()
        turn_base(self._base, HANGING)
        self._measured.visible, self._note.visible = False, True

    def remove(self) -> None:
        """Take all nodes out of the scene."""
        self._root.remove()
