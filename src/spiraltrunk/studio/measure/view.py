"""The compared takes: scene, scale, plot and map, with the take and the moment that are chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk.studio.drawing.axis_end import round_up
from spiraltrunk.studio.measure import texts
from spiraltrunk.studio.measure.picture import MeasurePicture
from spiraltrunk.studio.measure.take_map import draw_map, mark_moment
from spiraltrunk.studio.page.controls import Choice, Slider
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale
from spiraltrunk.workflows.validate.overlay import RunOverlay

_HEIGHT = 118
"""Height of the plot [px]."""

_RMSE, _NOW = "#0072B2", "#D55E00"
"""Colours of the plot's lines."""


@final
@dataclass(frozen=True, kw_only=True)
class Compared:
    """A comparison, as its work returned it."""

    runs: tuple[RunOverlay, ...]
    """The runs."""
    result: dict[str, Any]
    """Its figures."""
    names: dict[str, str]
    """What the person calls each take, by its file."""


@final
class CompareView:
    """What is shown of a comparison, in a container of its own."""

    def __init__(self, page: Page, folder: Any, picture: MeasurePicture, found: Compared) -> None:
        """Add controls and draw.

        Args:
            page: the page.
            folder: container of its controls.
            picture: what it draws into.
            found: the comparison.
        """
        self._page, self._picture, self._result = page, picture, found.result
        self._choices = {
            f"{i}. {found.names.get(take.source, take.source)}": (run, index)
            for i, (run, index, take) in enumerate(
                ((run, index, take) for run in found.runs for index, take in enumerate(run.takes)), 1
            )
        }
        first = next(iter(self._choices))
        self._n_section = found.runs[0].predicted.shape[1]
        self._top = 10.0
        self._folder = folder
        with folder:
            self._words = page.gui.add_html("")
            self._choice = Choice(page, "Take", tuple(self._choices), first, self._choose, hint="Take that is shown")
            self._slot = page.gui.add_folder(None)
            self._legend = page.gui.add_html("")
            self._map: Any = page.gui.add_image(
                np.zeros((10, 10, 3), np.uint8), label="Error by time (across) and section (tip above)", format="png"
            )
            self._lines = page.gui.add_html(texts.format_lines())
            self._plot: Any = self._add_plot()
            self._notes = self._add_notes(found.result["notes"])
        self._slider: Slider | None = None
        self._choose(first)

    def remove(self) -> None:
        """Take its controls out of the panel."""
        parts = (
            self._words,
            self._choice.handle,
            self._slot,
            self._legend,
            self._map,
            self._lines,
            self._plot,
            self._notes,
        )
        for part in parts:
            part.remove()

    def _add_notes(self, notes: Sequence[str]) -> Any:
        """What was irregular in the recordings, folded."""
        folder = self._page.gui.add_folder("Notes on the recordings", expand_by_default=False, visible=bool(notes))
        with folder:
            self._page.gui.add_html(texts.format_notes(notes))
        return folder

    def _choose(self, name: str) -> None:
        self._run, self._take = self._choices[name]
        one = self._run.takes[self._take]
        self._distance = self._run.compute_distance(self._take)
        held = self._distance[one.is_held]
        self._most = round_up(float(np.nanmax(held)), 1e-3)
        self._base_map = draw_map(self._distance, one.recorded, self._most)
        if self._slider is not None:
            self._slider.handle.remove()
        begin, end = float(one.time[0]), float(one.time[-1])
        scale = Scale(
            label="Moment", unit="s", least=round(begin, 2), most=round(end, 2), step=0.01, hint="Moment of the take"
        )
        last = np.flatnonzero(one.is_held & (one.shape == one.shape.max()))
        start = float(one.time[last[len(last) // 2]]) if len(last) else end
        with self._slot:
            self._slider = Slider(self._page, scale, round(start, 2), self._draw)
        self._legend.content = texts.format_scale(self._most)
        self._draw(self._slider.value)

    def _draw(self, time: float) -> None:
        """Show a moment [s]."""
        one = self._run.takes[self._take]
        moment = int(np.abs(one.time - time).argmin())
        with self._page.client.atomic():
            self._picture.draw(self._run, self._take, moment, self._most)
            self._words.content = texts.format_moment(self._run, self._take, moment, self._result)
            self._map.image = mark_moment(self._base_map, moment / max(1, len(one.time) - 1))
            self._plot_moment(moment)

    def _plot_moment(self, moment: int) -> None:
        sections = np.array(self._run.deviation.sections)
        rmse, now = self._run.deviation.per_section[sections - 1], self._distance[moment, sections - 1]
        top = round_up(1e3 * float(np.nanmax([*rmse, *now])), 1.0)
        if top != self._top:
            self._top = top
            self._plot.scales = self._build_scales()
        self._plot.data = (sections.astype(float), 1e3 * rmse, 1e3 * now)

    def _add_plot(self) -> Any:
        none = np.zeros(2)
        font: Any = {"labelFont": "12px sans-serif", "font": "11px sans-serif", "labelSize": 16}
        axes: Any = (
            {"label": "Section, 1 at the base", "size": 26, **font},
            {"label": "Error [mm]", "size": 38, **font},
        )
        dots = {"show": True, "size": 5}
        series: Any = (
            {"label": "section"},
            {"label": "RMSE of the run", "stroke": _RMSE, "width": 2, "points": dots},
            {"label": "at this moment", "stroke": _NOW, "width": 1.5, "points": dots, "dash": [6, 4]},
        )
        return self._page.gui.add_uplot(
            (np.array([1.0, 2.0]), none, none), series, height=_HEIGHT, axes=axes, legend={"show": False},
            scales=self._build_scales(), cursor={"drag": {"x": False, "y": False, "setScale": False}},
            padding=(8, 12, 0, 0),
        )  # fmt: skip

    def _build_scales(self) -> Any:
        return {"x": {"time": False, "range": (1.0, float(self._n_section))}, "y": {"range": (0.0, self._top)}}
