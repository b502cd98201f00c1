"""Sliders of the cables, and of their mean and differences."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.model.kinematics.cable_modes import build_cable_modes
from spiraltrunk.studio.page.controls import Slider
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale

_MODES = {
    "mean": ("Mean of all", "Mean of all pulls: lower leaves slack, higher winds the cables against each other"),
    "dorsal - ventral": ("Dorsal - ventral", "Cable on the dorsal side in, those on the ventral side out: bends"),
    "side": ("Side (twist)", "Cables of one side in, those of the other out: bends sideways, twists a bent trunk"),
}


@final
class CableControls:
    """A slider for each cable, and one for each mode of them."""

    def __init__(
        self,
        page: Page,
        folders: tuple[Any, Any],
        design: TrunkDesign,
        pull: np.ndarray,
        on_change: Callable[[np.ndarray], None],
    ) -> None:
        """Add the sliders.

        Args:
            page: the page.
            folders: containers of the cables, and of their mean and differences.
            design: the trunk.
            pull: first pull of each cable, shape (n_cable,) [m].
            on_change: called with all pulls [m] when one was changed.
        """
        self._on_change = on_change
        self._modes = build_cable_modes(design)
        self._most = design.cable_stroke
        self._pull = np.clip(np.array(pull), -self._most, self._most)
        stroke = 1e3 * self._most
        hint = "Cable pulled in since the straight trunk; below 0 it is let out, and slack where the trunk needs less"
        with folders[0]:
            self._cables = [
                Slider(page, _scale(f"Cable {i + 1}", stroke, hint), _to_mm(value), partial(self._take_cable, i))
                for i, value in enumerate(self._pull)
            ]
        with folders[1]:
            self._sliders = [
                Slider(page, self._scale_mode(i, name), _to_mm(value), partial(self._take_mode, i))
                for i, (name, value) in enumerate(zip(self._modes.names, self._modes.read(self._pull), strict=True))
            ]

    def show(self, pull: np.ndarray) -> None:
        """Show pulls (n_cable,) [m]; the sliders show them to a tenth of a millimetre."""
        self._pull = np.clip(np.array(pull), -self._most, self._most)
        for slider, value in zip(self._cables, self._pull, strict=True):
            slider.set(_to_mm(value))
        for slider, value in zip(self._sliders, self._modes.read(self._pull), strict=True):
            slider.set(_to_mm(value))

    def remove(self) -> None:
        """Take the sliders out of the panel."""
        for slider in (*self._cables, *self._sliders):
            slider.handle.remove()

    def _take_cable(self, cable: int, value_mm: float) -> None:
        pull = self._pull.copy()
        pull[cable] = value_mm / 1e3
        self._change(pull)

    def _take_mode(self, mode: int, value_mm: float) -> None:
        self._change(self._modes.change(self._pull, mode, value_mm / 1e3))

    def _change(self, pull: np.ndarray) -> None:
        self.show(pull)
        self._on_change(self._pull.copy())

    def _scale_mode(self, mode: int, name: str) -> Scale:
        label, hint = _MODES[name]
        return _scale(label, 1e3 * self._most * float(np.abs(self._modes.weights[mode]).sum()), hint)


def _scale(label: str, most: float, hint: str) -> Scale:
    rounded = max(float(np.floor(most)), 1.0)
    return Scale(label=label, unit="mm", least=-rounded, most=rounded, step=0.1, hint=hint)


def _to_mm(length: Any) -> float:
    """Length in millimetres, to a tenth, without a minus before zero."""
    return round(1e3 * float(length), 1) + 0.0
