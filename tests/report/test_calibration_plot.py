"""Pictures of calibrations and of joints on the bench show what they are given."""

import math

import numpy as np
import pytest

from spiraltrunk.report.calibration_plot import CalibrationBars, build_calibration_figure
from spiraltrunk.report.joint_bench_plot import LoadedJoint, RingDown, build_loads_figure
from spiraltrunk.report.style import write_figure

BARS = CalibrationBars(
    before=np.array([1.0, 0.5]), value=np.array([1.2, 0.4]), low=np.array([1.1, 0.3]), high=np.array([1.3, 0.5]),
    groups=("rest 0 deg", "twist"), errors=np.array([[1e-3, 2e-3, 3e-3], [2e-3, 4e-3, math.nan]]), is_held_out=True,
    title="virtual",
)  # fmt: skip


def test_stiffness_and_errors_are_drawn_in_their_units(tmp_path):
    figure = build_calibration_figure(BARS)
    left, right = figure.axes
    np.testing.assert_array_equal(left.lines[0].get_ydata(), BARS.before)
    heights = [bar.get_height() for bar in right.patches]
    np.testing.assert_allclose(heights, [1, 2, 2, 4, 3, math.nan])
    assert "held out" in right.get_ylabel()
    assert figure.get_suptitle() == "virtual"
    assert write_figure(figure, tmp_path / "a" / "c.png").stat().st_size > 1000


@pytest.mark.slow
def test_each_joint_has_its_panel_with_readings_and_both_laws(tmp_path):
    bend = np.radians([0.0, 10.0, 20.0])
    joints = [
        LoadedJoint(name=f"joint {i}", bend=bend, moment=0.3 * bend, beam=0.3, law=lambda q: 0.3 * q, faces_from=faces)
        for i, faces in enumerate((math.nan, 0.2, math.nan, 0.1, math.nan))
    ]
    time = np.linspace(0.0, 0.2, 50)
    joints.append(RingDown(name="ring", time=time, signal=np.cos(60 * time), law=lambda t: np.cos(60 * t)))
    figure = build_loads_figure(joints)
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert [axes.get_title() for axes in shown] == [joint.name for joint in joints]
    np.testing.assert_allclose(shown[0].lines[2].get_xdata(), [0, 10, 20])
    np.testing.assert_allclose(shown[-1].lines[1].get_ydata(), np.cos(60 * time))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "beam law alone", "fitted law", "readings", "faces meet"
    ]  # fmt: skip
    assert write_figure(figure, tmp_path / "l.png").stat().st_size > 1000
