"""Plots in a real browser: their axes are there, also where data arrive while they are laid out."""

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

TICKS = """() => Object.values(window.__viserTestpoints?.uplots ?? {}).map(({chart}) =>
  chart.axes.map((axis) => chart.width > 0 ? (axis._values ?? []).filter((one) => one !== null).length : 0))"""


class PlotTab:
    """A plot of fixed scales, whose data arrive at once, again and again."""

    name, title = "plot", "Plot"

    def __init__(self, page):
        self.page = page

    def build(self):
        scales = {"x": {"time": False, "range": (-30.0, 0.0)}, "y": {"range": (-5.0, 5.0)}}
        series = ({"label": "time"}, {"label": "a", "stroke": "#0072B2"})
        self.plot = self.page.gui.add_uplot((np.array([-30.0, 0.0]), np.zeros(2)), series, height=150, scales=scales)
        for i in range(40):
            self.page.later(f"data {i}", lambda: self.send(np.linspace(-8.0, 0.0, 20)), 0.05 * i)

    def send(self, time):
        self.plot.data = (time, np.zeros(len(time)))

    def show(self):
        pass

    hide = close = show

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass


@pytest.mark.slow
def test_a_plot_has_both_axes(studio, open_page):
    page = open_page(studio([PlotTab]))
    page.wait_for_timeout(4000)
    ((across, up),) = page.evaluate(TICKS)
    assert across >= 3
    assert up >= 3
