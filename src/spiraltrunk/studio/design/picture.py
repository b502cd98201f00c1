"""Picture of a design: the trunk, curled or straight, and the construction of its spiral."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple, final, get_args

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.report.shape.construction import Construction, build_construction, curled_pose
from spiraltrunk.report.solids.trunk_mesh import (
    Surface,
    TrunkSurfaces,
    build_rods,
    build_trunk_surfaces,
    curl_frames,
)
from spiraltrunk.studio.page.page import Page

View = Literal["curled", "straight"]
VIEWS: tuple[View, ...] = get_args(View)
"""Views of the trunk."""

OUTER, BACKBONE, INNER, TANGENT, OBJECT = (0, 114, 178), (213, 94, 0), (0, 158, 115), (230, 159, 0), (204, 121, 167)
"""Colours of the construction's lines, of the palette of Okabe and Ito."""

CABLE = (150, 30, 240)
"""Colour of the cables: violet, apart from all lines and parts in any colour vision, with a contrast of 5 to the light
ground and of 3 to the dark one."""

RAY, QUAD = (102, 108, 114), (90, 98, 106)
"""Colours of its rays, apart from the legend's other lines in any colour vision, and of its sections."""

_LINES = {
    "outer": OUTER, "backbone": BACKBONE, "inner": INNER, "tangent": TANGENT, "smallest": OBJECT, "rays": RAY,
    "sections": QUAD,
}  # fmt: skip
"""Lines of the construction and their colours."""

_THICK = ("outer", "backbone", "inner", "tangent", "smallest")

_PARTS = {
    "odd": (104, 124, 146), "even": (72, 92, 114), "joints": (230, 159, 0), "gripper": (86, 180, 233),
    "mount": (110, 116, 124),
}  # fmt: skip
"""Colours of the parts."""

_PAPER_TO_SCENE = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""The paper's x to the right, its y up."""

_BASE_TO_SCENE = np.array([[0.0, 1, 0, 0], [0, 0, -1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])
"""The base's axis down, dorsal to the right."""

_FOV = math.radians(30.0)
_MARGIN = 1.12
_GROWN = (0.55, 1.25)
"""Ratios of the picture's size to the fitted one beyond which it is fitted again [-]."""

_OFF = 1.5
"""Ratio of the camera's distance to the fitted one beyond which it is fitted again at rest [-]."""

_SAME = 0.01
"""Move of the camera, as a share of its distance, from which on a person moved it [-]."""

_CLEAR = 0.35
"""Opacity of the trunk before its construction [-]."""


_SCALE = (128, 128, 128)
"""Colour of the scale's bar."""


class _Line(NamedTuple):
    """A line of the picture."""

    segments: np.ndarray
    """Ends of its straight pieces in the scene, shape (n, 2, 3) [m]."""
    color: tuple[int, int, int]
    """Red, green and blue, 0 to 255."""
    radius: float
    """Half the diagonal of its cross-section [m]."""


@final
class DesignPicture:
    """Nodes below ``/design``."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._fitted = 0.0
        self._fits: list[np.ndarray] = []
        self._lines: set[str] = set()
        self._label: Any = None
        self._drawn: dict[str, Any] = {}
        self._boxes: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._shown = ("", False)

    def draw(self, design: TrunkDesign, view: View, with_construction: bool) -> None:
        """Draw a design; the camera moves where the view changes, or the size by more than `_GROWN`.

        Where a person moved the camera, it stays until the view changes.
        """
        is_curled = view == "curled"
        surfaces = build_trunk_surfaces(design, curl_frames(design, 1.0 if is_curled else 0.0))
        pose = _PAPER_TO_SCENE @ curled_pose(design) if is_curled else _BASE_TO_SCENE
        lines = build_construction(design) if with_construction else None
        plane, radius = _PAPER_TO_SCENE.copy(), 0.004 * _reach(design)
        if not is_curled:
            plane[:3, 3] = _find_room(design), 0.0, -design.length / 2
        with self._page.client.atomic():
            mount = None if is_curled else surfaces.mount
            self._draw_trunk(surfaces, pose, _CLEAR if is_curled and with_construction else None, mount)
            self._draw_lines(_list_lines(surfaces.cables, pose, lines, plane, radius))
            low, high = self._bounds()
            self._draw_scale(low, high)
            self._frame((view, with_construction), low, high)

    def fit(self) -> None:
        """Move the camera so that all is seen."""
        low, high = self._bounds()
        camera, middle = self._page.client.camera, (low + high) / 2
        position = middle + _find_distance(low, high) * np.array([0.14, -0.98, 0.14])
        with self._page.client.atomic():
            camera.fov = _FOV
            camera.up_direction = np.array([0.0, 0.0, 1.0])
            camera.position = position
            camera.look_at = middle
        self._fits.append(np.concatenate([position, middle]))
        self._fitted = float(np.max(high[[0, 2]] - low[[0, 2]]))

    def settle(self) -> None:
        """Fit the camera again once the design rests, where it is far too near or too far, and no person moved it.

        While a slider is dragged fast, the camera that the page reports may be one of some fits before; viser sends no
        position that equals the reported one, so that the page can be left with another.
        """
        camera, is_fitted = self._page.client.camera, self._is_fitted()
        distance = float(np.linalg.norm(np.array(camera.position) - np.array(camera.look_at)))
        self._fits = self._fits[-1:]
        if is_fitted and not 1 / _OFF < distance / _find_distance(*self._bounds()) < _OFF:
            self.fit()

    def _is_fitted(self) -> bool:
        """Whether the camera stands as one of the fits since the last rest left it: no person moved it."""
        camera = self._page.client.camera
        present = np.concatenate([camera.position, camera.look_at])
        most = _SAME * float(np.linalg.norm(present[:3] - present[3:]))
        return any(np.abs(present - fit).max() < most for fit in self._fits)

    def _frame(self, shown: tuple[str, bool], low: np.ndarray, high: np.ndarray) -> None:
        size = float(np.max(high[[0, 2]] - low[[0, 2]]))
        least, most = _GROWN
        is_off = not least * self._fitted < size < most * self._fitted
        if shown != self._shown or (is_off and self._is_fitted()):
            self._shown = shown
            self.fit()

    def _draw_trunk(
        self, surfaces: TrunkSurfaces, pose: np.ndarray, opacity: float | None, mount: Surface | None
    ) -> None:
        odd, even = surfaces.sections
        parts = {"odd": odd, "even": even, "joints": surfaces.joints, "gripper": surfaces.gripper, "mount": mount}
        for name, surface in parts.items():
            self._put_mesh(name, surface, pose, opacity)

    def _draw_lines(self, lines: dict[str, _Line]) -> None:
        """Draw lines in the place of those that were there."""
        for name in self._lines - lines.keys():
            self._remove(name)
        self._lines = set(lines)
        rods = build_rods([line.segments for line in lines.values()], [line.radius for line in lines.values()])
        for (name, line), rod in zip(lines.items(), rods, strict=True):
            box = self._put(name, rod, line.color, None)
            if name == "outer":
                self._boxes[name] = box

    def _draw_scale(self, low: np.ndarray, high: np.ndarray) -> None:
        """A bar of a round length below the picture."""
        size = float(high[0] - low[0])
        power = 10.0 ** math.floor(math.log10(size / 2))
        length = max(each * power for each in (1.0, 2.0, 5.0) if each * power <= size / 2)
        start = np.array([low[0], low[1], low[2] - 0.04 * float(high[2] - low[2])])
        bar = np.stack([start, start + np.array([length, 0.0, 0.0])])
        self._put("scale", build_rods([bar[None]], [0.004 * size])[0], _SCALE, None)
        if self._label is None:
            self._label = self._page.scene.add_label("/design/scale_label", "", anchor="top-center")
        self._label.text, self._label.position = f"{1e3 * length:g} mm", bar.mean(axis=0)

    def _put_mesh(self, name: str, surface: Surface | None, pose: np.ndarray, opacity: float | None) -> None:
        if surface is None:
            self._remove(name)
            return
        placed = Surface(_transform(surface.vertices, pose), surface.faces)
        self._boxes[name] = self._put(name, placed, _PARTS[name], opacity)

    def _put(
        self, name: str, surface: Surface, color: tuple[int, int, int], opacity: float | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draw a surface that is in the scene's frame, and return its bounds."""
        vertices = surface.vertices.astype(np.float32)
        drawn = self._drawn.get(name)
        if drawn is not None and np.array_equal(drawn.faces, surface.faces):
            drawn.vertices, drawn.opacity = vertices, opacity  # What is as it was is not sent.
        else:
            self._drawn[name] = self._page.scene.add_mesh_simple(
                f"/design/{name}", vertices, surface.faces, color=color, opacity=opacity, material="toon5",
                cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        return vertices.min(axis=0), vertices.max(axis=0)

    def _remove(self, name: str) -> None:
        handle = self._drawn.pop(name, None)
        self._boxes.pop(name, None)
        if handle is not None:
            handle.remove()

    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        boxes = self._boxes.values()
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


def _find_distance(low: np.ndarray, high: np.ndarray) -> float:
    """Distance of the camera from the middle of bounds of shape (3,) at which they are all seen [m]."""
    size = float(np.max(high[[0, 2]] - low[[0, 2]]))
    return _MARGIN * size / 2 / math.tan(_FOV / 2) + float(high[1] - low[1]) / 2


def _find_room(design: TrunkDesign) -> float:
    """Place of the pole beside the straight trunk [m]."""
    return -(1.15 * _reach(design) + max(design.housing.radius, float(design.section_radius[0])))


def _reach(design: TrunkDesign) -> float:
    """Radius of the outer contour at the base [m]."""
    return design.spiral.a * math.exp(design.spiral.b * design.theta_base)


def _transform(points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _list_lines(
    cables: np.ndarray, cable_pose: np.ndarray, lines: Construction | None, plane: np.ndarray, radius: float
) -> dict[str, _Line]:
    """Cables, and the lines of the construction where it is shown."""
    listed = {f"cable_{i}": _Line(_split(line, cable_pose), CABLE, radius) for i, line in enumerate(cables)}
    if lines is not None:
        for name, color in _LINES.items():
            segments = _split(getattr(lines, name), plane)
            listed[name] = _Line(segments, color, radius if name in _THICK else radius / 3)
    return listed


def _split(line: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Straight pieces in the scene of one line, shape (n, k), or several, shape (m, n, k), of 2 or 3 coordinates."""
    lines = line[None] if line.ndim == 2 else line
    segments = np.stack([lines[:, :-1], lines[:, 1:]], axis=2).reshape(-1, 2, line.shape[-1])
    if line.shape[-1] == 2:
        segments = np.concatenate([segments, np.zeros((len(segments), 2, 1))], axis=-1)
    return _transform(segments, pose)
